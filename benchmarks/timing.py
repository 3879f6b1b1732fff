"""Rates of several variants, measured in turns so that all see the same machine."""

import time
from collections.abc import Callable

Run = Callable[[], int]
"""Does a piece of work of a few milliseconds or more and returns how much of it there was."""


def best_rates(runs: dict[str, Run], seconds: float) -> dict[str, float]:
    """Work per second of each variant, of its fastest turn.

    Parameters
    ----------
    runs : dict of str to function
        Each is called once before, to warm up.
    seconds : float
        Least time for each variant.
    """
    for run in runs.values():
        run()
    best = dict.fromkeys(runs, 0.0)
    stop = time.perf_counter() + seconds * len(runs)
    while time.perf_counter() < stop:
        for name, run in runs.items():
            start = time.perf_counter()
            done = run()
            best[name] = max(best[name], done / (time.perf_counter() - start))
    return best
