"""Two speed thresholds instead of a table, for firmware that has only such settings."""

from dataclasses import asdict, dataclass
from textwrap import fill
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from sensorless.baselines.hysteresis import GAP, Hysteresis
from sensorless.baselines.linear import linear_table
from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.machine.motor import Motor
from sensorless.policy import Policy, TablePolicy
from sensorless.table.ks_table import Axis, KsTable
from sensorless.tuning.batch import costs

Floats = NDArray[np.float64]

SUITE, SEED, SIZE = "stress-1", 2025, 200
"""Scenarios of the role ``tune`` on which the cost is found."""
SPEEDS = 1001
"""Points on the speed axis, from standstill to 1.25 times its end."""
LEAST_FALL = 0.1
"""Least fall of k_s from standstill to the highest speed; below it there is nothing to switch."""
DIGITS = 1
"""Decimals of thresholds [r/min]."""

METHOD = (
    "least squares over the speed; the other axes at their nodes, with weights exp(-(x / a)^2) and "
    "a half the largest magnitude of the axis (low torque current counts most). Ramp: k_s falls "
    "from 1 at the first speed to 0 at the second. Hysteresis: the mean of its two branches "
    f"(1, 0.5, 0) is fitted, with a gap of at least +-{100 * GAP:g} %"
)


@dataclass(frozen=True)
class TwoThreshold:
    """Speeds [r/min, mechanical, as estimated]."""

    ramp: tuple[float, float]
    """k_s is 1 below the first, 0 above the second and straight between."""
    hysteresis: tuple[float, float]
    """Back to injection at the first, on to the observer at the second."""
    misfit: float
    """RMS difference between the ramp's k_s and the table's, with the weights of the fit."""


def fit(table: KsTable, motor: Motor) -> TwoThreshold | None:
    """Return the thresholds closest to the table; None if its k_s does not fall with the speed."""
    axis = next((a for a in table.axes if a.signal == "speed"), None)
    if axis is None:
        return None
    x = np.linspace(0.0, 1.25 * max(axis.hi, 0.01), SPEEDS)
    k_s, weight = _samples(table, x)
    mean = weight @ k_s
    if not mean[0] - mean[-1] >= LEAST_FALL:
        return None
    low, high = _ramp(x, mean)
    rpm = motor.n_rated_rpm
    off = np.clip((high - x) / (high - low), 0.0, 1.0) - k_s
    down, up = _hysteresis(x, mean)
    return TwoThreshold(
        (round(low * rpm, DIGITS), round(high * rpm, DIGITS)),
        (round(down * rpm, DIGITS), round(up * rpm, DIGITS)),
        float(np.sqrt(np.mean(weight @ off**2))),
    )


def _samples(table: KsTable, x: Floats) -> tuple[Floats, Floats]:
    """k_s (m, speeds) at the m combinations of the other axes' nodes, and their weights (m,)."""
    others = [a for a in table.axes if a.signal != "speed"]
    grids = [g.reshape(-1) for g in np.meshgrid(*(a.nodes for a in others), indexing="ij")]
    m = len(grids[0]) if grids else 1
    obs = np.zeros((m, len(x), SIGNAL_N), dtype=np.float32)
    obs[:, :, SIGNAL_NAMES.index("speed")] = x
    weight = np.ones(m)
    for a, nodes in zip(others, grids, strict=True):
        obs[:, :, SIGNAL_NAMES.index(a.signal)] = nodes[:, None]
        weight *= np.exp(-((nodes / _half(a)) ** 2))
    k_s = table.evaluate(obs.reshape(-1, SIGNAL_N)).reshape(m, len(x)).astype(np.float64)
    return k_s, weight / weight.sum()


def _half(axis: Axis) -> float:
    return 0.5 * max(abs(axis.lo), abs(axis.hi))


def _ramp(x: Floats, mean: Floats) -> tuple[float, float]:
    """Ends of the ramp over rated speed: the best of a coarse grid, then refined."""

    def misfit(band: Floats) -> float:
        low, width = band
        if low < 0.0 or width < x[1]:
            return np.inf
        return float(np.mean((np.clip((low + width - x) / width, 0.0, 1.0) - mean) ** 2))

    coarse = x[:: SPEEDS // 50]
    starts = [np.array([a, b - a]) for a in coarse for b in coarse if b > a]
    start = min(starts, key=misfit)
    end = minimize(
        misfit,
        start,
        method="Nelder-Mead",
        options={"xatol": 1e-7, "fatol": 1e-14, "maxiter": 2000},
    )
    low, width = (float(y) for y in end.x)
    return low, low + width


def _hysteresis(x: Floats, mean: Floats) -> tuple[float, float]:
    """Speeds at which 1, 0.5 and 0 follow each other best; each threshold on its own."""
    first = np.cumsum((mean - 1.0) ** 2 - (mean - 0.5) ** 2)
    second = np.cumsum((mean - 0.5) ** 2 - mean**2)
    down, up = float(x[np.argmin(first)]), float(x[np.argmin(second)])
    centre = max(0.5 * (down + up), float(x[1]))
    return min(down, (1.0 - GAP) * centre), max(up, (1.0 + GAP) * centre)


def loss(table: KsTable, rule: TwoThreshold, motor: Motor, design: DriveDesign) -> dict[str, Any]:
    """Table, ramp and hysteresis on the same scenarios: lost rate, torque deviation and ripple."""
    low, high = (n / motor.n_rated_rpm for n in rule.ramp)
    down, up = (n / motor.n_rated_rpm for n in rule.hysteresis)
    policies: tuple[Policy, ...] = (
        TablePolicy("table", table),
        TablePolicy("ramp", linear_table(low, high)),
        Hysteresis("hysteresis", down, up),
    )
    scenarios = suite(SUITE, motor, SEED, SIZE, role="tune")
    found, _ = costs(policies, scenarios, SimFactory(motor, design))
    return {
        p.name: {name: round(x, 9) for name, x in asdict(c).items()}
        for p, c in zip(policies, found, strict=True)
    }


def two_threshold(table: KsTable, motor: Motor, design: DriveDesign) -> dict[str, Any]:
    """Entry ``two_threshold`` of ``ks_table.json``: speeds [r/min], how they were found, cost."""
    rule = fit(table, motor)
    if rule is None:
        return {"none": "k_s of this table does not fall with the speed"}
    return {
        "ramp": {"k_s_1_below_r_min": rule.ramp[0], "k_s_0_above_r_min": rule.ramp[1]},
        "hysteresis": {"injection_below_r_min": rule.hysteresis[0],
                       "observer_above_r_min": rule.hysteresis[1]},
        "fit": METHOD,
        "ramp_k_s_rms": round(rule.misfit, 6),
        "scenarios": {"suite": SUITE, "role": "tune", "seed": SEED, "size": SIZE},
        "performance": loss(table, rule, motor, design),
    }  # fmt: skip


def readme(entry: dict[str, Any] | None) -> str:
    """Section of the folder's README."""
    if entry is None:
        return "Not fitted in this export, which was made with `--no-fit`."
    if "none" in entry:
        return f"There are none: {entry['none']}."
    ramp, gap = entry["ramp"].values(), entry["hysteresis"].values()
    does = {
        "table": "the table of this folder",
        "ramp": "`k_s` is 1 below {:g} r/min, 0 above {:g} r/min, linear between".format(*ramp),
        "hysteresis": "injection below {:g} r/min, observer above {:g} r/min".format(*gap)
        + ", unchanged between them",
    }
    rows = "\n".join(
        f"| {name} | {does[name]} | {100 * c['lost_rate']:.1f} % | {100 * c['torque_dev']:.2f} % "
        f"| {100 * c['torque_ripple']:.2f} % |"
        for name, c in entry["performance"].items()
    )
    fitted = fill(f"Fit: {entry['fit']}.", 100)
    return f"""For firmware that has only speed settings, these are the two thresholds of the
estimated speed that come closest to the table (`two_threshold` in `ks_table.json`). Their cost is
over {SIZE} scenarios of the suite `{SUITE}`; neither training nor `sensorless evaluate` uses them.
Torque deviation is that from the same drive with a position sensor. Deviation and ripple are RMS
values over rated torque, averaged over the drives that a rule does not lose.

| rule | what it does | drives lost | torque deviation | torque ripple |
| --- | --- | --- | --- | --- |
{rows}

{fitted}
The RMS difference between the ramp's `k_s` and the table's, with the same weights, is
{entry["ramp_k_s_rms"]:.3f}."""
