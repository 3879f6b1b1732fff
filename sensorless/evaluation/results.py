"""The results of an evaluation: file, and table for the terminal."""

import json
import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.markup import escape
from rich.table import Table

from sensorless.files import write_atomic

DIGITS = 9
"""Significant digits of a number in the file."""

RATES = {"lost_rate": "lost_ci", "not_held_rate": "not_held_rate_ci"}
"""Of all scenarios, and the name of the Wilson interval of each."""

Columns = tuple[tuple[str, str, float, int], ...]

COLUMNS: Columns = (
    ("lost_rate", "lost [%]\nnot held [%]", 100.0, 1),
    ("torque_dev_rms", "torque\ndev. [%]", 100.0, 2),
    ("torque_ripple_rms", "torque\nripple [%]", 100.0, 2),
    ("overshoot_pct", "overshoot\n[%]", 1.0, 1),
    ("angle_err_rms_deg", "angle\nerror [°]", 1.0, 2),
)
"""Of the table: name, heading, factor, decimals."""

HANDOVER_COLUMNS: Columns = (
    ("torque_ripple_window", "window:\nripple [%]", 100.0, 2),
    ("torque_p2p_window", "window: peak\nto peak [%]", 100.0, 1),
    ("overshoot_clean_pct", "twin has none:\novershoot [%]", 1.0, 2),
    ("overshoot_clean_above", "twin has none:\n> 2 % in [%]", 100.0, 1),
    ("not_held_rate", "not held\n[%]", 100.0, 1),
)
"""Of the second table: torque in the window ``ripple_metrics.HANDOVER``, overshoot in the steps in
which the twin has none, and drives not held."""


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
    """by name: ``estimator`` as in ``DriveDesign``, rates, means over the scenarios survived,
    intervals, ``by_quadrant`` and ``by_speed``, ``worst`` cases, and ``scenarios``; ``bound`` where
    it knows the truth"""
    paired: dict[str, dict[str, Any]]
    """by name: differences to the first policy"""

    def to_json(self, scenarios: bool = True) -> str:
        """Text of the file, the same for the same results; null where there is no number.

        Without ``scenarios`` the numbers of every single scenario are left out.
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
        """In brackets, what sets a policy apart: a bound, or not on the design's estimator."""
        policy = self.policies[name]
        if policy["bound"]:
            return "(bound)"
        own = policy["estimator"]
        return "" if own == self.design["estimator"] else f"({own})"

    def table(self, columns: Columns = COLUMNS) -> Table:
        """Rates over feasible scenarios, means over those survived, each with its 95 % interval."""
        title = f"{self.suite}, seed {self.seed}, {self.size} scenarios, motor {self.motor}"
        beyond = max(p["infeasible_rate"] for p in self.policies.values())
        title += f", {100.0 * beyond:.1f} % not feasible" if beyond > 0.0 else ""
        caption = (
            "rates (95 % interval) of feasible; others: mean over survivors ± half the interval"
        )
        table = Table(title=escape(title), caption=caption)
        table.add_column("policy", overflow="fold")
        for _, heading, _, _ in columns:
            table.add_column(heading, justify="right")
        for name, policy in self.policies.items():
            note = self.note(name)
            label = escape(name) + (f"\n{note}" if note else "")
            table.add_row(label, *(_cell(policy, *column) for column in columns))
        return table


def _cell(policy: dict[str, Any], key: str, _: str, factor: float, decimals: int) -> str:
    """Number and interval; the lost rate has the one of those not held below it."""
    if key in RATES:
        keys = RATES if key == "lost_rate" else (key,)
        return "\n".join(_rate(policy, name, factor, decimals) for name in keys)
    value = factor * policy[key]
    if not math.isfinite(value):
        return "–"
    low, high = policy[f"{key}_ci"]
    half = 0.5 * factor * (high - low)
    return f"{value:.{decimals}f}" + (f" ±{half:.{decimals}f}" if math.isfinite(half) else "")


def _rate(policy: dict[str, Any], key: str, factor: float, decimals: int) -> str:
    low, high = (factor * x for x in policy[RATES[key]])
    return f"{factor * policy[key]:.{decimals}f} ({low:.0f}–{high:.0f})"


def _text(x: Any, indent: str = "") -> str:
    """JSON with one line for every entry of an object, so that lists of numbers stay on a line."""
    if not isinstance(x, dict) or not x:
        return json.dumps(_plain(x), allow_nan=False)
    inner = indent + " "
    lines = (f"{inner}{json.dumps(str(key))}: {_text(value, inner)}" for key, value in x.items())
    return "{\n" + ",\n".join(lines) + f"\n{indent}}}"


def _plain(x: Any) -> Any:
    """Values that JSON knows; floats rounded, null for what is not finite."""
    if isinstance(x, np.ndarray | np.generic):
        x = x.tolist()
    if isinstance(x, list | tuple):
        return [_plain(entry) for entry in x]
    if isinstance(x, float):
        return float(f"{x:.{DIGITS}g}") if math.isfinite(x) else None
    return x
