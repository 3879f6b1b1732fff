"""Drives that run decision by decision on the same arrays, whose C pointers are taken once."""

import numpy as np

from sensorless.core.api import SMALL, TRACE_NAMES, Array, ffi, lib, pointer, threads_allowed


def running(sims: Array) -> Array:
    """(n,) bool: which drives are neither lost nor at the end of their scenario."""
    return np.asarray((sims["lost"] == 0) & (sims["k"] < sims["k_end"]))


class Run:
    """`sim_run` again and again on the same drives.

    Parameters
    ----------
    sims : array of SIM, shape (n,)
    periods : int
        PWM periods of a decision.
    obs : array of float32, shape (n, SIGNAL_N)
    gains : array of GAINS, shape (n,), optional
    """

    def __init__(self, sims: Array, periods: int, obs: Array, gains: Array | None = None) -> None:
        self._k_s = np.zeros(len(sims), dtype=np.float32)
        self._words = (
            pointer(sims, "sim_t[]"),
            len(sims),
            periods,
            lib.SIMD_AVX512,
            threads_allowed() if len(sims) * periods >= SMALL else 1,
            pointer(self._k_s, "float[]"),
            ffi.NULL if gains is None else pointer(gains, "sim_gains_t[]"),
            pointer(obs, "float[]"),
        )

    def decide(self, k_s: Array) -> None:
        """Advance every drive by one decision under weights (n,)."""
        self._k_s[:] = k_s
        lib.sim_run(*self._words)


class Recording:
    """One drive from its start on, with a row for every period.

    Parameters
    ----------
    sim : array of SIM, shape (1,)
    obs : array of float32, shape (1, SIGNAL_N)
        Filled with the signals, at once and after every `advance`.
    """

    def __init__(self, sim: Array, obs: Array) -> None:
        room = int(sim["k_end"][0] - sim["k"][0])
        self._sim, self._obs = pointer(sim, "sim_t[]"), pointer(obs, "float[]")
        self._table = np.zeros((max(room, 0), len(TRACE_NAMES)))
        self._out = pointer(self._table, "double[]")
        self._n = 0
        self._now = self._sim[0]
        self._x = self._now.drive.x
        lib.sim_signals(self._sim, 1, self._obs)

    @property
    def rows(self) -> Array:
        """Rows of ``TRACE_NAMES`` so far, (periods, len(TRACE_NAMES))."""
        return self._table[: self._n]

    @property
    def at_end(self) -> bool:
        """Whether the drive has reached the end of its scenario."""
        return bool(self._now.k >= self._now.k_end)

    @property
    def lost(self) -> bool:
        """Whether the drive is lost."""
        return bool(self._now.lost != 0)

    def advance(self, periods: int, k_s: float) -> int:
        """Advance the drive by up to ``periods`` periods and return how many they were."""
        most = min(periods, len(self._table) - self._n)
        at = self._out + self._n * len(TRACE_NAMES)
        n = int(lib.sim_trace(self._sim, most, k_s, at))
        lib.sim_signals(self._sim, 1, self._obs)
        self._n += n
        return n

    def status(self) -> tuple[bool, bool, int, int]:
        """Whether the drive has an alarm of lost lock, is out of control by it; fault bits; tests.

        The tests are those that failed in all alarms so far, bits as in ``lock_state_t.reason``.
        """
        x = self._x
        out = x.start.phase != lib.START_DONE and x.fault & lib.FAULT_LOCK != 0
        return x.lock.alarm != 0, out, x.fault, x.lock.reason
