"""How drives did by quadrant and by speed.

The sensored twin decides where a drive is: it follows the same profile with the true angle, so all
policies are sorted alike, and wrong torque does not move a drive to another quadrant.
"""

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import Array
from sensorless.evaluation.metrics.ripple import ripple_sq
from sensorless.evaluation.rollout import Rollout

SPEED_EDGES = (0.0, 0.05, 0.1, 0.2, 0.3, 0.5, 1.0)
"""Lower edges of the bins of speed over rated speed; the last bin is open."""

QUADRANTS = (
    "forward motoring",
    "forward regenerating",
    "reverse motoring",
    "reverse regenerating",
    "standstill",
    "no load",
)
STILL, FREE = 0.01, 0.02
"""Speed over rated below which a drive stands still, and torque below which it has no load."""

PLACE = np.dtype(
    [
        ("periods", np.int64),
        ("err_sq", np.float64),
        ("dev_sq", np.float64),
        ("ripple_sq", np.float64),
        ("lost", np.bool_),
    ]
)
"""One drive in one place: its PWM periods there; sums over them of the squared angle error [rad^2],
squared torque deviation from the twin and squared torque ripple (both over rated torque); whether
it was lost there."""

Places = NDArray[np.int64]


def quadrant(r: Rollout) -> Places:
    """(d, n) index into ``QUADRANTS`` of each decision."""
    speed, torque = _twin(r)
    regenerating = speed * torque < 0.0
    place = np.where(speed < 0.0, 2, 0) + regenerating
    place[np.abs(torque) < FREE] = QUADRANTS.index("no load")
    place[np.abs(speed) < STILL] = QUADRANTS.index("standstill")
    return np.asarray(place, dtype=np.int64)


def speed_bin(r: Rollout) -> Places:
    """(d, n) index into ``SPEED_EDGES`` of each decision."""
    return np.asarray(np.digitize(np.abs(_twin(r)[0]), SPEED_EDGES) - 1, dtype=np.int64)


def by_place(r: Rollout) -> dict[str, Array]:
    """Sums of each drive in each place, arrays of ``PLACE``: ``quadrant`` (n, 6), ``speed`` (n, 7).

    A drive was lost where it was in its last decision; drives in scenarios that are not feasible
    count as lost nowhere.
    """
    return {
        "quadrant": _sums(r, quadrant(r), len(QUADRANTS)),
        "speed": _sums(r, speed_bin(r), len(SPEED_EDGES)),
    }


def _twin(r: Rollout) -> tuple[Array, Array]:
    """Mean speed and torque of the twin in each decision, over the rated ones; 0 after the end."""
    count = np.maximum(r.sums["n"], 1.0)
    rated = r.motor.omega_m_rated
    return r.sums["omega_m_twin"] / count / rated, r.sums["tau_twin"] / count / r.motor.tau_rated


def _sums(r: Rollout, place: Places, places: int) -> Array:
    rated_sq = r.motor.tau_rated**2
    parts = {
        "periods": r.sums["n"],
        "err_sq": r.sums["err_sq"],
        "dev_sq": r.sums["dev_sq"] / rated_sq,
        "ripple_sq": ripple_sq(r, "tau_sq") / rated_sq,
    }
    n = len(r.lost)
    out = np.zeros((n, places), dtype=PLACE)
    bins = (np.where(r.alive, place, places) + (places + 1) * np.arange(n)).ravel()
    for name, x in parts.items():  # a sum in the order of time, those after the end set aside
        found = np.bincount(bins, x.ravel(), n * (places + 1)).reshape(n, places + 1)
        out[name] = found[:, :places]
    rows = np.flatnonzero((r.lost != 0) & r.feasible & r.alive.any(axis=0))
    last = r.alive[:, rows].sum(axis=0) - 1
    out["lost"][rows, place[last, rows]] = True
    return out
