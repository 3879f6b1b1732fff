"""Where work runs: one function over many chunks, in this process or on a Ray cluster.

What is computed does not depend on the engine: the caller makes the chunks, each chunk is all that
its result depends on, and results come back in the order of the chunks.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Protocol, TypeVar

Chunk = TypeVar("Chunk")
Result = TypeVar("Result")


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
