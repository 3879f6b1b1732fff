"""Sums up a traced run: one row of numbers per plateau of the speed plan."""

import numpy as np

from sensorless.core.api import Array
from sensorless.evaluation.metrics import RIPPLE_WINDOW
from sensorless.evaluation.metrics.step import SETTLED
from sensorless.evaluation.trace import Trace, mean_of_two, outcome
from sensorless.plain_table import PlainTable
from sensorless.units import RAD_S_TO_RPM

STEADY = 0.2
"""Length of the end of a plateau that counts as steady [s]."""
STAYS = 0.1
"""Least part of a plateau that the speed has to stay settled for at its end: a swing does not."""
SHORTEST = 0.05
"""Least length of a plateau, and of what of it comes before its load changes [s]."""


def summary_table(t: Trace, policy: str, tau_rated: float) -> PlainTable:
    """One row for every stretch of constant speed reference; ``tau_rated`` in N m."""
    title = f"{policy}: {outcome(t)}"
    seeking = t["t"][t["starting"] > 0.0]
    if len(seeking):
        title += f", rotor found after {1e3 * seeking[-1]:.0f} ms"
    caption = (
        "settled: within 2 % of the step; overshoot: in % of it; both until the load changes; "
        "steady: largest 20 ms mean of the last 0.2 s, in which faster swings do not show; ripple: "
        "RMS about that mean in them, in % of rated torque, without the injection's"
    )
    table = PlainTable(title=title, caption=caption)
    for heading in (
        "from [s]",
        "target\n[r/min]",
        "settled\nafter [s]",
        "over-\nshoot\n[%]",
        "k_s at\nend",
        "steady\nangle\nerror [°]",
        "largest\nangle\nerror [°]",
        "torque\nripple\n[%]",
    ):
        table.add_column(heading, justify="right")
    for row in plateaus(t):
        table.add_row(
            f"{row['from_s']:.2f}",
            f"{row['target_rpm']:.0f}",
            _number(row["settled_s"], 3),
            _number(row["overshoot_pct"], 1),
            f"{row['k_s']:.2f}",
            f"{row['angle_err_steady_deg']:.2f}",
            f"{row['angle_err_max_deg']:.1f}",
            f"{100.0 * row['torque_ripple_nm'] / tau_rated:.2f}",
        )
    return table


def _number(x: float, decimals: int) -> str:
    return f"{x:.{decimals}f}" if np.isfinite(x) else "–"


def plateaus(t: Trace) -> list[dict[str, float]]:
    """Stretches of constant speed reference of ``SHORTEST``, up to the verdict of a lost drive.

    Returns
    -------
    list of dict
        ``from_s`` [s]; ``target_rpm`` [r/min]; ``settled_s``: time until the speed stays within 2 %
        of the step [s], NaN if that is only for the last tenth; ``overshoot_pct`` of the step;
        both until the load changes, NaN where that is too soon; ``k_s``: mean of the last 0.2 s;
        ``angle_err_steady_deg``: largest magnitude of its 20 ms mean there; ``angle_err_max_deg``,
        the start sequence left out; ``torque_ripple_nm``: RMS of the last 0.2 s about its centred
        20 ms mean, of means of two samples, which have no injection [N m].
    """
    ref, omega = RAD_S_TO_RPM * t["omega_m_ref"], RAD_S_TO_RPM * t["omega_m"]
    edges = np.flatnonzero(np.abs(np.diff(ref)) > 1e-6) + 1
    starts = np.concatenate([[0], edges])
    stops = np.concatenate([edges, [len(ref)]])
    T_s = float(t["t"][1] - t["t"][0]) if len(ref) > 1 else 1.0
    rows = []
    before, end = float(omega[0]), int(np.sum(~t["judged"]))
    for a, b in zip(starts, stops, strict=True):
        if (b - a) * T_s < SHORTEST or a >= end:
            continue
        rows.append(_plateau(t, omega, int(a), min(int(b), end), before, T_s))
        before = float(ref[b - 1])
    return rows


def _until_load(tau_load: Array, a: int, b: int) -> int:
    """First period of [a, b) in which the load begins to move, other than at a; or b."""
    moves = np.abs(np.diff(tau_load[a:b])) > 1e-9
    again = np.flatnonzero(moves & np.logical_or.accumulate(~moves))
    return a + 1 + int(again[0]) if len(again) else b


def _plateau(
    t: Trace,
    omega: Array,
    a: int,
    b: int,
    before: float,
    T_s: float,
) -> dict[str, float]:
    target = RAD_S_TO_RPM * float(t["omega_m_ref"][b - 1])
    step = target - before
    c = _until_load(t["tau_load"], a, b)
    away = np.flatnonzero(np.abs(omega[a:c] - target) > SETTLED * max(abs(step), 1e-9))
    settled = 0.0 if len(away) == 0 else (away[-1] + 1) * T_s
    beyond = float(np.max(np.sign(step) * (omega[a:c] - target), initial=0.0))
    told = abs(step) > 1.0 and (c == b or (c - a) * T_s >= SHORTEST)
    err = np.where(t["starting"][a:b] > 0.0, 0.0, np.rad2deg(t["theta_e_err"][a:b]))
    late = slice(-round(STEADY / T_s), None)
    torque = mean_of_two(t["tau"][a:b])[late]
    return {
        "from_s": a * T_s,
        "target_rpm": target,
        "settled_s": settled if told and settled <= (1.0 - STAYS) * (c - a) * T_s else np.nan,
        "overshoot_pct": 100.0 * beyond / abs(step) if told else np.nan,
        "k_s": float(np.mean(t["k_s"][a:b][late])),
        "angle_err_steady_deg": float(np.max(np.abs(_smooth(err[late], T_s)))),
        "angle_err_max_deg": float(np.max(np.abs(err))),
        "torque_ripple_nm": _ripple(torque, T_s),
    }


def _smooth(x: Array, T_s: float) -> Array:
    """Means of 20 ms; x as it is if it is shorter."""
    n = max(1, round(RIPPLE_WINDOW / T_s))
    return np.convolve(x, np.ones(n) / n, mode="valid") if len(x) >= n else x


def _ripple(x: Array, T_s: float) -> float:
    """RMS of x about its centred 20 ms mean; about its mean if it is shorter."""
    mean = _smooth(x, T_s)
    a = (len(x) - len(mean)) // 2
    about = x[a : a + len(mean)] - mean if len(mean) < len(x) else x - np.mean(x)
    return float(np.sqrt(np.mean(about**2)))
