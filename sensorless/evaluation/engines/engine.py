"""Where work runs: one function over many chunks, in this process or on a Ray cluster.

What is computed does not depend on the engine: the caller makes the chunks, each chunk is all that
its result depends on, and results come back in the order of the chunks.
"""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import Protocol, TypeVar

from sensorless.errors import UserError

Chunk = TypeVar("Chunk")
Result = TypeVar("Result")

ENGINES = ("local", "ray")


class Engine(Protocol):
    """Runs chunks of work, at least 100 ms each so that sending them costs little."""

    def map(self, function: Callable[[Chunk], Result], chunks: Iterable[Chunk]) -> Iterator[Result]:
        """Results in the order of the chunks; holds no more of either than it needs to be busy."""


class Local:
    """One chunk after the other in this process."""

    def map(self, function: Callable[[Chunk], Result], chunks: Iterable[Chunk]) -> Iterator[Result]:
        """Each result when it is asked for."""
        return map(function, chunks)


LOCAL = Local()


@contextmanager
def engine_named(name: str, address: str | None = None) -> Iterator[Engine]:
    """Engine by name for the time of a ``with`` block.

    Parameters
    ----------
    name : str
        One of ``ENGINES``.
    address : str, optional
        HOST:PORT of a running Ray cluster; default: a cluster of this machine's own.

    Raises
    ------
    UserError
        Unknown name, an address without Ray, no Ray, or no cluster at that address.
    """
    if name not in ENGINES:
        raise UserError(f"engine: {name!r}; allowed: {', '.join(ENGINES)}")
    if name == "local":
        if address is not None:
            raise UserError(f"ray-address: {address!r}; allowed: with --engine ray only")
        yield LOCAL
        return
    from sensorless.evaluation.engines.ray_engine import ray_engine

    with ray_engine(address) as engine:
        yield engine
