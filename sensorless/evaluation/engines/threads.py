"""Runs chunks on several threads of this process: the core computes without Python's lock."""

import copy
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from itertools import chain, islice

from sensorless.core.api import threads_allowed
from sensorless.evaluation.engines.engine import Chunk, Result


class Threads:
    """As many threads as calls of the core may use.

    Every chunk runs on copies of the function and of itself, on one thread too: policies keep what
    they saw.
    """

    def map(self, function: Callable[[Chunk], Result], chunks: Iterable[Chunk]) -> Iterator[Result]:
        """Yield results in the order of the chunks; no more than two a thread are under way.

        Work that cannot be copied, say of a policy that holds a file, is done one by one.
        """
        waiting = iter(chunks)
        first = list(islice(waiting, 1))
        every = chain(first, waiting)
        if not _can_be_copied((function, first)):
            return map(function, every)
        count = threads_allowed()
        if count == 1:
            return map(partial(_on_copies, function), every)
        return _side_by_side(function, every, count)


LOCAL = Threads()


def _on_copies(function: Callable[[Chunk], Result], chunk: Chunk) -> Result:
    own, its_own = copy.deepcopy((function, chunk))
    return own(its_own)


def _side_by_side(
    function: Callable[[Chunk], Result], chunks: Iterator[Chunk], count: int
) -> Iterator[Result]:
    window: deque[Future[Result]] = deque()
    pool = ThreadPoolExecutor(count)
    try:
        while True:
            for chunk in islice(chunks, 2 * count - len(window)):
                own, its_own = copy.deepcopy((function, chunk))
                window.append(pool.submit(own, its_own))
            if not window:
                return
            yield window.popleft().result()
    finally:
        pool.shutdown(cancel_futures=True)


def _can_be_copied(work: object) -> bool:
    try:
        copy.deepcopy(work)
    except Exception:  # a policy may raise anything
        return False
    return True
