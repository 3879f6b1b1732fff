"""Where work runs: one function over many chunks, on threads or on a Ray cluster.

Results do not depend on the engine: the caller makes the chunks, a result depends on its chunk
alone, and results come back in the order of the chunks.
"""

from collections.abc import Callable, Iterable, Iterator
from typing import Protocol, TypeVar

Chunk = TypeVar("Chunk")
Result = TypeVar("Result")


class Engine(Protocol):
    """Runs chunks of work; a chunk should take 100 ms or more, so that sending it costs little."""

    def map(self, function: Callable[[Chunk], Result], chunks: Iterable[Chunk]) -> Iterator[Result]:
        """Yield results in the order of the chunks, and hold no more of either than needed."""
