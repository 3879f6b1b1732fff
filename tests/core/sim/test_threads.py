"""Threads of the core: how many, and what happens where there can be none."""

import os
import subprocess
import sys
import threading
from collections.abc import Iterator

import numpy as np
import pytest
import torch

from sensorless.core.api import THREADS, Array, threads_allowed
from sensorless.errors import UserError
from tests.helpers.drives import advance, drives

LINUX = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="needs /proc and rlimits")


def test_default_is_the_cores_of_this_process(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(THREADS, raising=False)
    assert threads_allowed() == len(os.sched_getaffinity(0))


def test_variable_overrides(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(THREADS, "5")
    assert threads_allowed() == 5


@pytest.mark.parametrize("value", ["0", "-1", "two", "1.5", "²"])
def test_bad_variable(value: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(THREADS, value)
    with pytest.raises(
        UserError, match=f"{THREADS}: '{value}' is not a number of threads; set 1 or more"
    ):
        advance(drives(), 500, None)


@LINUX
def test_a_long_call_starts_threads_and_a_short_one_does_not() -> None:
    """Counted from outside while the call runs."""

    def most(periods: int) -> int:
        sims = drives(256)
        sims["k_end"] = 10**9
        call = threading.Thread(target=advance, args=(sims, periods, 3))
        before = len(os.listdir("/proc/self/task"))
        call.start()
        seen = 0
        while call.is_alive():
            seen = max(seen, len(os.listdir("/proc/self/task")))
        return seen - before

    assert most(8_000) == 3
    assert most(5) <= 1


@LINUX
def test_where_threads_cannot_start() -> None:
    """Without address space for a stack, the calling thread does all of the work."""
    code = """
import resource, sys, threading
from tests.helpers.drives import advance, drives
expected = advance(drives(), 1000, 1).tobytes()
sims = drives()
pages = int(open("/proc/self/statm").read().split()[0])
room = pages * resource.getpagesize() + 2**21
resource.setrlimit(resource.RLIMIT_AS, (room, room))
try:
    threading.Thread(target=print).start()
    sys.exit("a thread could start")
except RuntimeError:
    pass
sys.exit(None if advance(sims, 1000, 7).tobytes() == expected else "other results")
"""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=os.path.dirname(__file__) + "/../../..",
        env={**os.environ, "PYTHONPATH": ".", "OPENBLAS_NUM_THREADS": "1"},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr


@LINUX
def test_fork_after_threads() -> None:
    """A child of a process that has used threads uses them as well."""
    expected = advance(drives(), 1000, 3).tobytes()
    child = os.fork()
    if child == 0:
        os._exit(0 if advance(drives(), 1000, 3).tobytes() == expected else 1)
    assert os.waitpid(child, 0)[1] == 0


@pytest.fixture
def flushing() -> Iterator[None]:
    """Denormal numbers count as zero in this thread, as a fast-math library would leave it."""
    if not torch.set_flush_denormal(True):
        pytest.skip("this processor cannot flush denormal numbers")
    yield
    torch.set_flush_denormal(False)


def tiny() -> Array:
    """Drives without injection whose filter of its error holds a denormal number."""
    sims = drives(256)
    sims["drive"]["x"]["signal"]["hfi_var"] = 1e-40
    sims["drive"]["x"]["k_s"] = 0.0
    return sims


@pytest.mark.parametrize("threads", [1, 3])
def test_flush_to_zero_has_no_say(threads: int, request: pytest.FixtureRequest) -> None:
    """The core computes with denormal numbers, and leaves the setting of the process alone."""
    start = tiny()
    expected = advance(start.copy(), 100, threads, k_s=0.0)
    still = np.full(1, 1e-40, np.float32)
    left = expected["drive"]["x"]["signal"]["hfi_var"]
    assert 0.0 < left.min() <= left.max() < np.finfo(np.float32).tiny
    request.getfixturevalue("flushing")
    sims = advance(start.copy(), 100, threads, k_s=0.0)
    assert torch.from_numpy(still).mul(1.0).item() == 0.0
    assert sims.tobytes() == expected.tobytes()
