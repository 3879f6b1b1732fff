"""What quantising a schedule costs: every metric of an evaluation with float32 and with Q15 nodes.

    python studies/q15_study.py [reference logistic-tuned ...]

Both tables are looked up by the firmware's own code, over the same scenarios; means are over those
that both survive. Writes ``results/studies/q15.json``.
"""

import argparse
import math
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import UserError, in_one_line
from sensorless.evaluation.aggregate import paired
from sensorless.evaluation.evaluate import Scores, score
from sensorless.files import ensure_writable, write_record
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import Signals, TablePolicy
from sensorless.table.image import lookup
from sensorless.versions import versions

POLICIES = ("reference", "reference-flux", "logistic-tuned")
LIMIT = 0.01
"""Largest change of a metric that is accepted."""
OVER = {
    "angle_err_mean_deg": "angle_err_rms_deg",
    "overshoot_excess_pct": "overshoot_pct",
    "overshoot_clean_pct": "overshoot_pct",
    "dip_excess_pct_s": "dip_pct_s",
}
"""What is about zero, being left over beside the twin, and what its change is put over instead."""
SHARES = {
    "overshoot_clean_above": 1.0,
    "hops": 1.0,
    "k_s_hop": 1.0,
    "not_held": 1.0,
    "not_held_rate": 1.0,
    "swing_pct": 100.0,
    "away_s": 1.0,
}
"""What is near zero, made by few scenarios that pass a threshold, and what its change is put over:
1 for shares of scenarios and weights, 100 for percent of rated speed, 1 for seconds off it."""


class Q15Policy(TablePolicy):
    """A schedule table as the firmware holds it in Q15."""

    def __init__(self, exact: TablePolicy) -> None:
        super().__init__(exact.name, exact.table, exact.settings)
        self._image = self.table.record("q15").reshape(1), self.table.stored("q15")

    def act(self, obs: Signals) -> Signals:
        """Interpolated weights (n,) of the Q15 nodes."""
        return lookup(*self._image, np.ascontiguousarray(obs, dtype=np.float32))


def table_policy(word: str, motor: Motor) -> TablePolicy:
    """Policy by its word.

    Raises
    ------
    UserError
        It is no table.
    """
    policy = make_policy(word, motor)
    if not isinstance(policy, TablePolicy):
        raise UserError(f"policy: {word!r} is not a table; give one that is")
    return policy


def changes(exact: Scores, rounded: Scores, seed: int) -> dict[str, dict[str, Any]]:
    """Each metric with float32 (``f32``) and Q15 (``q15``) nodes, and its ``change``.

    The change is a share of the metric, see ``OVER`` and ``SHARES``; ``change_ci`` is the 95 %
    interval of its mean over the scenarios.
    """
    pair = paired(rounded.lost, rounded.metrics, exact.lost, exact.metrics, seed)
    base = {name: x for name, x in pair["there"].items() if math.isfinite(x)}
    out = {}
    for name, x in base.items():
        over = SHARES.get(name) or abs(base[OVER.get(name, name)]) or 1.0
        interval = [end / over for end in pair[f"{name}_ci"]]
        out[name] = {"f32": x, "q15": x + pair[name], "change": pair[name] / over}
        out[name] |= {"change_ci": interval}
    return out


def study(word: str, motor: Motor, suite: str, seed: int, size: int) -> dict[str, Any]:
    """One policy's table both ways."""
    policy = table_policy(word, motor)
    table = policy.table
    rows = SuiteRows(suite, motor, seed, size)
    factory = SimFactory(motor, DriveDesign())
    exact, rounded = (score(p, rows, factory) for p in (policy, Q15Policy(policy)))
    return {
        "nodes": int(table.values.size),
        "bytes": {form: int(table.stored(form).nbytes) for form in ("f32", "q15")},
        "survived_both": int(np.sum((exact.lost == 0) & (rounded.lost == 0))),
        "lost_otherwise": int(np.sum((exact.lost == 0) != (rounded.lost == 0))),
        "metrics": changes(exact, rounded, seed),
    }


def show(word: str, found: dict[str, Any]) -> Table:
    """Table for the terminal."""
    size = ", ".join(f"{form} {n} bytes" for form, n in found["bytes"].items())
    caption = (
        f"lost with one of the two alone: {found['lost_otherwise']}; {', '.join(SHARES)}: points"
    )
    table = Table(title=f"{word}: {found['nodes']} nodes, {size}", caption=caption)
    for heading in ("metric", "float32", "Q15", "change [%]", "95 % interval"):
        table.add_column(heading, justify="left" if heading == "metric" else "right")
    for name, row in found["metrics"].items():
        style = None if abs(row["change"]) < LIMIT else "bold red"
        low, high = (f"{100.0 * x:+.3f}" for x in row["change_ci"])
        cells = (f"{row['f32']:.6g}", f"{row['q15']:.6g}", f"{100.0 * row['change']:+.3f}")
        table.add_row(name, *cells, f"{low} … {high}", style=style)
    return table


def main() -> None:
    """Measure, print and record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("policies", nargs="*", default=list(POLICIES))
    parser.add_argument("--suite", default="stress-1")
    parser.add_argument("--seed", type=a_seed, default=11)
    parser.add_argument("--size", type=a_count, default=2000)
    parser.add_argument("--out", type=Path, default=Path("results/studies/q15.json"))
    options = parser.parse_args()
    ensure_writable(options.out.parent)
    motor, console, found = Motor.load("paper"), Console(), {}
    for word in options.policies:
        found[word] = study(word, motor, options.suite, options.seed, options.size)
        console.print(show(word, found[word]))
    setting = {name: getattr(options, name) for name in ("suite", "seed", "size")}
    record = {**setting, "motor": motor.name, "versions": versions(), "policies": found}
    write_record(options.out, record)
    console.print(f"wrote {options.out}")


if __name__ == "__main__":
    in_one_line(main)
