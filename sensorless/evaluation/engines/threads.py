"""Runs chunks on several threads of this process: the core computes without Python's lock."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from itertools import islice

from sensorless.core.api import threads_allowed
from sensorless.evaluation.engines.engine import Chunk, Result


class Threads:
    """As many threads as calls of the core may use; the function must not change what it shares."""

    def map(self, function: Callable[[Chunk], Result], chunks: Iterable[Chunk]) -> Iterator[Result]:
        """Yield results in the order of the chunks; no more than two a thread are under way."""
        waiting, count = iter(chunks), threads_allowed()
        window: deque[Future[Result]] = deque()
        with ThreadPoolExecutor(count) as pool:
            while True:
                for chunk in islice(waiting, 2 * count - len(window)):
                    window.append(pool.submit(function, chunk))
                if not window:
                    return
                yield window.popleft().result()
