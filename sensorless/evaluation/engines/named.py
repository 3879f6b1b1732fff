"""An engine from a word of the command line."""

from collections.abc import Iterator
from contextlib import contextmanager

from sensorless.errors import UserError
from sensorless.evaluation.engines.engine import Engine
from sensorless.evaluation.engines.threads import LOCAL

ENGINES = ("local", "ray")


@contextmanager
def engine_named(name: str, address: str | None = None) -> Iterator[Engine]:
    """Engine by name for the duration of a ``with`` block.

    Parameters
    ----------
    name : str
        One of ``ENGINES``.
    address : str, optional
        HOST:PORT of a running Ray cluster; by default one is started on this computer.

    Raises
    ------
    UserError
        The name is unknown, Ray is not installed, an address came without Ray, or there is no
        cluster at it.
    """
    if name not in ENGINES:
        raise UserError(f"engine: {name!r} does not exist; choose from {', '.join(ENGINES)}")
    if name == "local":
        if address is not None:
            raise UserError(f"ray-address: {address!r} needs --engine ray")
        yield LOCAL
        return
    from sensorless.evaluation.engines.ray_engine import ray_engine

    with ray_engine(address) as engine:
        yield engine
