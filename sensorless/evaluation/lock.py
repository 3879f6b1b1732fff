"""What a drive noticed of lost lock, and whether it came back: beside the judge's verdict.

The judge's verdict (``lost``) stands whatever the drive does afterwards. The run goes on after it,
so that alarm and recovery can be seen; no other metric counts that time.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import Array, lib
from sensorless.decision import decision_time
from sensorless.evaluation.rates import mean
from sensorless.machine.motor import Motor

BAND = 0.02
"""Band around the twin's speed, over rated; ``metrics.held`` has the same."""
EARLY = 0.1
"""Longest time by which an alarm that has ended may precede the verdict that it belongs to [s]; one
before that is a false one. So long before or after it, a drive whose angle error passes the
judge's limit was close to a loss."""
IN_TIME = 0.05
"""Latest alarm after the verdict that counts as detected [s]."""
BACK_IN = 0.3
"""Time from the alarm within which a drive has to be back [s]."""
STAYS = 0.02
"""Time for which it has to stay, to be back [s]."""

Floats = NDArray[np.float64]

LOCK = ("alarm_s", "back_s", "watched_s", "false_alarms", "near_losses")
"""Numbers of `LockWatch.scores`, one per scenario each."""


def in_control(sims: Array, band: float) -> NDArray[np.bool_]:
    """Whether drives (n,) run, within ``band`` [rad/s] of their twin's speed and at their angle."""
    x, y = sims["drive"]["x"], sims["drive"]["y"]
    away = np.abs(y["omega_m"] - sims["twin"]["y"]["omega_m"])
    with np.errstate(invalid="ignore"):  # a lost drive may have left all numbers
        turn = sims["plant"]["n_p"] * sims["control"]["T_s"] * y["omega_m"]
        off = y["theta_e"] - turn - x["est"]["theta"]  # the estimate is of a period before
        err = np.abs(np.angle(np.exp(1j * off)))
    good = (away <= band) & (err <= sims["err_limit"])
    return np.asarray(good & (x["start"]["phase"] == lib.START_DONE))


class LockWatch:
    """Looks at n drives after every decision.

    Parameters
    ----------
    motor : Motor
    n : int
    """

    def __init__(self, motor: Motor, n: int) -> None:
        self._step = decision_time(motor)
        self._band = BAND * motor.omega_rated / motor.n_p
        self._T_s = motor.T_s
        self._before = np.full(n, -np.inf)
        self._after = np.full(n, np.inf)
        self._back = np.full(n, np.inf)
        self._since = np.full(n, np.inf)
        self._alarms = np.zeros(n, dtype=np.int64)
        self._early = np.zeros(n, dtype=np.int64)
        self._lost = np.zeros(n, dtype=np.bool_)
        self._kept = np.zeros(n, dtype=np.bool_)
        self._over = np.full(n, -np.inf)
        self._close = np.zeros(n, dtype=np.bool_)
        self._near = np.zeros(n, dtype=np.int64)
        self._now = 0.0
        self._of: Array | None = None

    def look(self, sims: Array) -> None:
        """Take in one decision of the drives, an array of ``SIM`` (n,)."""
        self._now += self._step
        if self._of is not sims:  # the same in every decision, and its fields take time to find
            self._of, self._ends, self._limit = sims, sims["lost"], sims["err_limit"]
            self._told, self._error = sims["drive"]["x"]["lock"]["alarms"], sims["sums"]["err_max"]
        lost = self._ends != 0
        new = self._told > self._alarms
        self._alarms[:] = self._told
        self._look_close(lost)
        if not (np.count_nonzero(new) or np.count_nonzero(lost)):  # a tenth of the time of ``any``
            return
        x = sims["drive"]["x"]
        self._kept |= lost & ~self._lost & (x["lock"]["alarm"] != 0)
        self._lost = lost
        verdict = self._T_s * sims["k_lost"]
        stale = self._before < np.where(lost, verdict, self._now) - EARLY
        stale &= np.isfinite(self._before) & ~self._kept & (new | lost)
        self._early += stale
        self._near += stale & self._close
        self._before = np.where(stale, -np.inf, self._before)
        self._close = np.where(new & ~lost, self._now - self._over <= EARLY, self._close)
        self._before = np.where(new & ~lost, self._now, self._before)
        self._after = np.where(new & lost, np.minimum(self._after, self._now), self._after)
        self._look_back(sims, lost)

    def _look_close(self, lost: NDArray[np.bool_]) -> None:
        """Whether the angle error passed the judge's limit next to the last alarm."""
        over = self._error > self._limit
        if np.count_nonzero(over):
            over &= ~lost
            self._over = np.where(over, self._now, self._over)
            self._close |= over & (self._now - self._before <= EARLY)

    def _look_back(self, sims: Array, lost: NDArray[np.bool_]) -> None:
        """Whether lost drives are in control again, at their angle and their twin's speed."""
        good = lost & in_control(sims, self._band)
        self._since = np.where(good, np.minimum(self._since, self._now), np.inf)
        stays = self._now - self._since >= STAYS
        self._back = np.where(stays, np.minimum(self._back, self._since), self._back)

    def scores(self, sims: Array) -> dict[str, Floats]:
        """``LOCK``, after the last decision.

        Returns
        -------
        dict of arrays (n,)
            ``alarm_s``: from verdict to alarm [s], negative if the alarm came first, infinite
            without one. ``back_s``: from that alarm until the drive was back [s], infinite if it
            never was. ``watched_s``: from the verdict to the scenario's end [s]. These are NaN
            without a verdict. ``false_alarms``: alarms that belong to none; ``near_losses``: those
            of them next to an angle error beyond the judge's limit.
        """
        lost = sims["lost"] != 0
        verdict = self._T_s * sims["k_lost"]
        alarm = np.where(np.isfinite(self._before), self._before, self._after)
        last = np.isfinite(self._before) & ~lost
        early, near = self._early + last, self._near + (last & self._close)
        with np.errstate(invalid="ignore"):
            values = (
                alarm - verdict,
                np.where(np.isfinite(alarm), self._back - alarm, np.inf),
                self._T_s * sims["k_end"] - verdict,
            )
        out = {k: np.where(lost, v, np.nan) for k, v in zip(LOCK, values, strict=False)}
        counts = {"false_alarms": early, "near_losses": near}
        return out | {name: n.astype(np.float64) for name, n in counts.items()}


def lock_summary(lock: dict[str, Floats], lost: NDArray[np.int32], time: Floats) -> dict[str, Any]:
    """Rates over scenarios that lasted long enough after the verdict; NaN of none.

    False alarms are those in scenarios that hold; ``early_alarms`` those in scenarios lost later.

    Parameters
    ----------
    lost : (n,) bits of ``CAUSES``
    time : (n,) time lived, up to the verdict [s]
    """
    feasible = (lost & lib.LOST_TWIN) == 0
    gone = feasible & (lost != 0)
    alarm, watched = lock["alarm_s"], lock["watched_s"]
    judged = gone & (watched >= IN_TIME)
    found = judged & (alarm <= IN_TIME)
    room = judged & np.isfinite(alarm) & (watched - np.maximum(alarm, 0.0) >= BACK_IN + STAYS)
    back = lock["back_s"][room] <= BACK_IN
    held = feasible & ~gone
    hours = float(time[held].sum()) / 3600.0
    false, near = lock["false_alarms"], lock["near_losses"]
    return {
        "detected_rate": mean(found[judged]),
        "detect_ms": float(np.median(1e3 * alarm[found])) if found.any() else math.nan,
        "recovered_rate": mean(back),
        "false_alarms_per_hour": float(false[held].sum()) / hours if hours > 0.0 else math.nan,
        "lock_counts": {
            "lost": int(gone.sum()),
            "watched": int(judged.sum()),
            "detected": int(found.sum()),
            "could_recover": int(room.sum()),
            "recovered": int(back.sum()),
            "false_alarms": int(false[held].sum()),
            "near_losses": int(near[held].sum()),
            "early_alarms": int(false[gone].sum()),
        },
    }
