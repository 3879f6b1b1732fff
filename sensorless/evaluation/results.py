"""The results of an evaluation: file, and table for the terminal."""

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.core.api import Array
from sensorless.design.words import text_of
from sensorless.envs.scenarios.machines_suite import NAME as MACHINES
from sensorless.envs.scenarios.machines_suite import SCENARIOS
from sensorless.envs.scenarios.scenario import LOST_ANGLE_DEG, LOST_TIME
from sensorless.evaluation.metrics.held import BACK_TIME, BAND_PCT
from sensorless.evaluation.metrics.hop import HOP
from sensorless.evaluation.metrics.ripple import HANDOVER
from sensorless.files import write_atomic
from sensorless.plain_json import plain
from sensorless.plain_table import PlainTable

DIGITS = 9
"""Significant digits of a number in the file."""

RATES = {"lost_rate": "lost_ci", "not_held_rate": "not_held_rate_ci"}
"""Rates over the feasible scenarios, each with the name of its Wilson interval."""

Columns = tuple[tuple[str, str, float, int], ...]

COLUMNS: Columns = (
    ("lost_rate", "lost [%]\nnot held [%]", 100.0, 1),
    ("torque_dev_rms", "torque\ndev. [%]", 100.0, 2),
    ("torque_ripple_rms", "torque\nripple [%]", 100.0, 2),
    ("overshoot_pct", "overshoot\n[%]", 1.0, 1),
    ("angle_err_rms_deg", "angle\nerror [°]", 1.0, 2),
)
"""Columns of the main table: name, heading, factor, decimals."""

HANDOVER_COLUMNS: Columns = (
    ("torque_ripple_window", "window:\nripple [%]", 100.0, 2),
    ("torque_p2p_window", "window: peak\nto peak [%]", 100.0, 1),
    ("overshoot_clean_pct", "twin has none:\novershoot [%]", 1.0, 2),
    ("overshoot_clean_above", "twin has none:\n> 2 % in [%]", 100.0, 1),
    ("hops", "k_s hops\nin [%]", 100.0, 1),
)
"""Columns of the second table: torque in the window ``metrics.ripple.HANDOVER``, overshoot in the
steps in which the twin has none, and weights that move at rest."""

MEANS = (
    "Rates (95 % interval) are of feasible scenarios, others means over survivors ± half the "
    "interval."
)
CAPTIONS = {
    COLUMNS: (
        f"lost: angle error above {LOST_ANGLE_DEG:g}° for more than {1e3 * LOST_TIME:g} ms, or a "
        f"trip. not held: the speed is off the twin's by more than {BAND_PCT:g} % of rated "
        f"{BACK_TIME:g} s after a change, or swings. The twin is the same drive with a position "
        "sensor; torque dev. is the deviation from its torque, and what it cannot do is not "
        f"feasible. {MEANS}"
    ),
    HANDOVER_COLUMNS: (
        f"The window is where the twin's speed is {100 * HANDOVER[0]:g} to {100 * HANDOVER[1]:g} % "
        "of rated and the lead passes from one estimator to the other. twin has none: speed steps "
        f"that the twin follows without overshoot. k_s hops: by more than {HOP:g} while reference, "
        f"load and twin rest; of scenarios with such a time. {MEANS}"
    ),
}
"""Below a table: its terms."""


@dataclass(frozen=True)
class Results:
    """One suite under several policies. Every field is plain data: numbers, text, lists, dicts."""

    suite: str
    seed: int
    size: int
    motor: str
    motor_digest: str
    design: dict[str, Any]
    versions: dict[str, str]
    policies: dict[str, dict[str, Any]]
    """by name: ``estimator`` as in ``DriveDesign``, ``own`` settings that differ from ``design``,
    rates, means over the survived scenarios, intervals, ``by_quadrant`` and ``by_speed``, ``worst``
    cases, ``scenarios``, and ``bound`` if it knows the truth"""
    paired: dict[str, dict[str, Any]]
    """by name: differences to the first policy"""

    @property
    def count(self) -> int:
        """Scenarios of each policy; ``size`` counts machines where there are several."""
        return self.size * (SCENARIOS if self.suite == MACHINES else 1)

    def to_json(self, scenarios: bool = True) -> str:
        """Text of the file, the same for the same results; null where there is no number.

        Without ``scenarios`` it leaves out the numbers of every single scenario.
        """
        data = asdict(self)
        if not scenarios:
            for policy in data["policies"].values():
                del policy["scenarios"]
        return _text(data) + "\n"

    def write(self, path: Path, scenarios: bool = True) -> None:
        """Write the file as a whole or not at all.

        Raises
        ------
        UserError
            The file cannot be written there.
        """
        write_atomic(path, self.to_json(scenarios))

    def note(self, name: str) -> str:
        """Say in brackets that a policy is a bound, or which settings of its own it runs on."""
        policy = self.policies[name]
        words = ["told truth"] if policy["bound"] else []
        words += [
            value if key == "estimator" else f"{key}={text_of(value)}"
            for key, value in policy["own"].items()
        ]
        return f"({', '.join(words)})" if words else ""

    def label(self, name: str) -> str:
        """Name of a policy and, on a line of its own, its note."""
        note = self.note(name)
        return name + (f"\n{note}" if note else "")

    def table(self, columns: Columns = COLUMNS) -> PlainTable:
        """Rates over feasible scenarios and means over the survivors, with 95 % intervals."""
        what = f"{self.size} scenarios, motor {self.motor}"
        if self.suite == MACHINES:
            what = f"{SCENARIOS} scenarios each on {self.motor}"
        title = f"{self.suite}, seed {self.seed}, {what}"
        beyond = max(p["infeasible_rate"] for p in self.policies.values())
        title += f", {100.0 * beyond:.1f} % not feasible" if beyond > 0.0 else ""
        table = PlainTable(title=title, caption=CAPTIONS[columns], pad_edge=False)
        table.add_column("policy", overflow="fold", min_width=12)
        for _, heading, _, _ in columns:
            table.add_column(heading, justify="right")
        for name, policy in self.policies.items():
            table.add_row(self.label(name), *(_cell(policy, *column) for column in columns))
        return table


def _cell(policy: dict[str, Any], key: str, _: str, factor: float, decimals: int) -> str:
    """Number and interval; below the lost rate stands the rate of those not held."""
    if key in RATES:
        keys = RATES if key == "lost_rate" else (key,)
        return "\n".join(_rate(policy, name, factor, decimals) for name in keys)
    value = factor * policy[key]
    if not math.isfinite(value):
        return "–"
    low, high = policy[f"{key}_ci"]
    half = 0.5 * factor * (high - low)
    return f"{value:.{decimals}f}" + (f" ±{half:.{decimals}f}" if math.isfinite(half) else "")


@dataclass(frozen=True)
class Envelope:
    """Scenarios of the suite ``envelope`` as their grid (load, speed), lowest first."""

    lost: Array
    """(n, n) bool"""
    beyond: Array
    """(n, n) bool: the sensored twin fails too"""
    error: Array
    """(n, n) angle error, RMS up to the end of a lost drive [deg]; NaN if there is none"""

    @classmethod
    def of(cls, rows: dict[str, Any]) -> "Envelope":
        """Grid of the ``scenarios`` of a policy."""
        side = math.isqrt(len(rows["lost"]))
        beyond = ["twin" in (cause or "") for cause in rows["lost_cause"]]
        error = np.array(rows["angle_err_rms_deg"], dtype=np.float64)
        grids = (np.array(rows["lost"]), np.array(beyond), error)
        return cls(*(grid.reshape(side, side).T for grid in grids))

    @property
    def held_pct(self) -> float:
        """Points that hold, over those that the sensored twin holds [%]; NaN without such."""
        return float(100.0 * np.mean(~self.lost[~self.beyond])) if not self.beyond.all() else np.nan


def _rate(policy: dict[str, Any], key: str, factor: float, decimals: int) -> str:
    if not math.isfinite(policy[key]):
        return "–"  # no scenario was feasible
    low, high = (factor * x for x in policy[RATES[key]])
    return f"{factor * policy[key]:.{decimals}f} ({low:.{decimals}f}–{high:.{decimals}f})"


def _text(x: object, indent: str = "") -> str:
    """JSON with one line per entry of an object, so that a list of numbers stays on one line."""
    if not isinstance(x, dict) or not x:
        return json.dumps(plain(x, DIGITS), allow_nan=False)
    inner = indent + " "
    lines = (f"{inner}{json.dumps(str(key))}: {_text(value, inner)}" for key, value in x.items())
    return "{\n" + ",\n".join(lines) + f"\n{indent}}}"
