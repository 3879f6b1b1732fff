"""What an episode of ``sensorless/Blend-v1`` earns under three rules, by time between decisions.

    python studies/return_study.py

The same scenarios with decisions every 5 and every 1 ms, k_s alone, on the sliding-mode observer.
Returns are without the price of lost lock and over the scenarios survived; deviation and ripple are
those of ``sensorless evaluate``. Writes ``results/studies/returns.json``.
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.decision import RUNNING, TRAINING
from sensorless.design.drive import DriveDesign
from sensorless.envs.blend_v1 import GainVectorEnv
from sensorless.envs.returns import acts
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import in_one_line
from sensorless.evaluation.evaluate import score
from sensorless.files import ensure_writable, write_record
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import Policy, design_for
from sensorless.versions import versions

POLICIES = ("logistic-tuned", "eq25", "gated-tuned")
DESIGN = DriveDesign(estimator="smo")


def episodes(policy: Policy, rows: SuiteRows, decision: float) -> tuple[Any, Any]:
    """Return of each scenario without the price of lost lock (n,), and whether it is lost (n,)."""
    n, design = len(rows), design_for(policy, DESIGN)
    env = GainVectorEnv(n, gains=(), motor=rows.motor, design=design, decision_period=decision)
    act = acts(policy, env)
    obs, _ = env.reset(options={"scenario": rows.draw()})
    earned, lost, alive = np.zeros(n), np.zeros(n, dtype=bool), np.ones(n, dtype=bool)
    while alive.any():
        obs, reward, terminated, truncated, info = env.step(act(obs))
        earned[alive] += (reward - info["lost_penalty"])[alive]
        lost |= alive & terminated
        alive &= ~(terminated | truncated)
    return earned, lost


def study(word: str, rows: SuiteRows) -> dict[str, Any]:
    """One rule at both intervals."""
    found: dict[str, Any] = {}
    for name, decision in (("5 ms", TRAINING), ("1 ms", RUNNING)):
        earned, lost = episodes(make_policy(word, rows.motor), rows, decision)
        kept = earned[~lost]
        found[name] = {"return": kept.mean(), "worst": kept.min(), "lost": int(lost.sum())}
    scores = score(make_policy(word, rows.motor), rows, SimFactory(rows.motor, DESIGN))
    kept = scores.lost == 0
    names = ("torque_dev_rms", "torque_ripple_rms")
    return found | {name: float(np.nanmean(scores.metrics[name][kept])) for name in names}


def show(policies: dict[str, dict[str, Any]]) -> Table:
    """Table for the terminal."""
    table = Table(title="returns without the losses")
    for heading in ("rule", "5 ms", "1 ms", "lost, 5 ms", "worst, 5 ms", "deviation", "ripple"):
        table.add_column(heading, justify="left" if heading == "rule" else "right")
    for word, x in policies.items():
        cells = [f"{x[name]['return']:.1f}" for name in ("5 ms", "1 ms")]
        cells += [str(x["5 ms"]["lost"]), f"{x['5 ms']['worst']:.0f}"]
        cells += [f"{100.0 * x[name]:.2f}" for name in ("torque_dev_rms", "torque_ripple_rms")]
        table.add_row(word, *cells)
    return table


def main() -> None:
    """Measure, print and record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--seed", type=a_seed, default=11)
    parser.add_argument("--size", type=a_count, default=400)
    parser.add_argument("--out", type=Path, default=Path("results/studies/returns.json"))
    options = parser.parse_args()
    ensure_writable(options.out.parent)
    motor, console = Motor.load("paper"), Console()
    rows = SuiteRows("stress-1", motor, options.seed, options.size)
    found = {word: study(word, rows) for word in POLICIES}
    console.print(show(found))
    setting = {"suite": "stress-1", "seed": options.seed, "size": options.size}
    record = {**setting, "motor": motor.name, "versions": versions(), "policies": found}
    write_record(options.out, record)
    console.print(f"wrote {options.out}")


if __name__ == "__main__":
    in_one_line(main)
