"""What drives notice of lost lock, and whether they come back: every suite, estimator and action.

    python studies/lock_study.py [--motor NAME ...] [--estimator NAME ...] [--suite NAME ...]

A policy with `lost_lock` report and restart. Prints for each machine, estimator and action what
`sensorless evaluate` writes of lost lock, over all suites together. Action `truth` is restart with
the true angle and speed at each moment at which the drive takes control again: losses that it does
not bring back are not the search's, the estimator cannot carry that load. With --out the result is
written to a file.
"""

import argparse
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from sensorless.core.api import Array, lib
from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SUITES, SuiteRows
from sensorless.evaluation.lock import BACK_IN, IN_TIME, LOCK, STAYS, lock_summary
from sensorless.evaluation.rollout import CAUSES, at_a_time, rollouts
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import Policy, Signals, decide, design_for
from sensorless.versions import versions

ACTIONS = ("report", "restart", "truth")
KNOWN = tuple(name for name in SUITES if name not in ("starts", "machines"))
"""Suites of one machine whose drives know their angle at first."""
MACHINES = ("paper", "ipmsm_2200w", "pmsyrm_5600w", "brusa_hsm1")


class Acting:
    """A policy on drives with this action; with ``truth`` they take control again on the truth."""

    sensored = False
    privileged = True

    def __init__(self, inner: Policy, action: str, truth: bool) -> None:
        self.inner, self.name, self.truth = inner, inner.name, truth
        self.settings: Mapping[str, Any] = {**inner.settings, "lost_lock": action}
        self._seeks: NDArray[np.bool_] = np.zeros(0, dtype=np.bool_)

    def reset(self, n: int) -> None:
        """Nobody seeks."""
        self.inner.reset(n)
        self._seeks = np.zeros(n, dtype=np.bool_)

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """The policy's own."""
        return self.inner.act(obs)

    def act_knowing(self, obs: Signals, sims: Array) -> NDArray[np.float32]:
        """The policy's own; set drives that have just taken control on the truth."""
        seeks = sims["drive"]["x"]["start"]["phase"] != lib.START_DONE
        for j in np.flatnonzero(self._seeks & ~seeks & self.truth):
            x, y = sims["drive"]["x"][j], sims["drive"]["y"][j]
            for loop in (x["est"], x["hfi"]["pll"], x["emf"]["pll"]):
                loop["theta"], loop["omega"] = y["theta_e"], sims["omega_scale"][j] * y["omega_m"]
            x["smo"]["omega_f"] = x["est"]["omega"]
            x["control"]["i_1"]["d"], x["control"]["i_1"]["q"] = y["i_d"], y["i_q"]
            x["emf"]["valid"] = 0.0
        self._seeks = seeks
        return decide(self.inner, obs, sims)


def watched(
    motor: Motor, policy: Policy, design: DriveDesign, suites: list[str], seed: int, size: int
) -> tuple[dict[str, Any], dict[str, Any]]:
    """``lock_summary`` over these suites, and the arrays that it is of."""
    factory = SimFactory(motor, design)
    runs = []
    for suite in suites:
        scenarios = SuiteRows(suite, motor, seed, size).draw()
        some = min(64, at_a_time(scenarios, motor))
        for r in rollouts(policy, scenarios, factory, some, go_on=True):
            runs.append((r.lost, r.periods * motor.T_s, r.lock))
    lost, time = (np.concatenate([run[j] for run in runs]) for j in (0, 1))
    lock = {name: np.concatenate([run[2][name] for run in runs]) for name in LOCK}
    feasible = (lost & CAUSES["twin"]) == 0
    held = float(time[feasible & (lost == 0)].sum())
    row = {**lock_summary(lock, lost, time, CAUSES["twin"]), "held_s": round(held)}
    return row, {**lock, "gone": feasible & (lost != 0)}


def possible(restart: dict[str, Any], truth: dict[str, Any]) -> dict[str, int]:
    """Losses that the truth brings back in time, and how many of them the drive itself does."""
    room = restart["gone"] & (restart["watched_s"] >= IN_TIME) & np.isfinite(restart["alarm_s"])
    room &= restart["watched_s"] - np.maximum(restart["alarm_s"], 0.0) >= BACK_IN + STAYS
    could, back = (room & (run["back_s"] <= BACK_IN) for run in (truth, restart))
    return {"possible": int(could.sum()), "possible_recovered": int((could & back).sum())}


def rows_of(motor: Motor, policy: Policy, design: DriveDesign, args: Any) -> list[dict[str, Any]]:
    """One row an action."""
    rows, arrays = [], {}
    for action in args.action:
        truth = action == "truth"
        who = Acting(policy, "restart" if truth else action, truth)
        row, arrays[action] = watched(motor, who, design, list(args.suite), args.seed, args.size)
        rows.append({"motor": motor.name, "policy": policy.name, "estimator": design.estimator,
                     "lost_lock": action} | row)  # fmt: skip
        if action == "truth" and "restart" in arrays:
            rows[-1] |= possible(arrays["restart"], arrays["truth"])
    return rows


def show(found: list[dict[str, Any]]) -> None:
    """Print one line a machine, estimator and action."""
    table = Table(box=None)
    for heading in ("machine", "policy", "estimator", "lost_lock"):
        table.add_column(heading)
    for heading in ("held s", "false", "near", "early", "lost", "detected %", "after ms", "back %"):
        table.add_column(heading, justify="right")
    table.add_column("of possible", justify="right")
    for row in found:
        n = row["lock_counts"]
        counts = (n["false_alarms"], n["near_losses"], n["early_alarms"], n["lost"])
        table.add_row(
            *(row[name] for name in ("motor", "policy", "estimator", "lost_lock")),
            *(str(x) for x in (row["held_s"], *counts)),
            f"{100.0 * row['detected_rate']:.1f}",
            f"{row['detect_ms']:.0f}",
            f"{100.0 * row['recovered_rate']:.0f} of {n['could_recover']}",
            f"{row['possible_recovered']} of {row['possible']}" if "possible" in row else "",
        )
    Console(width=150).print(table)


def main() -> None:
    """Run, print, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--motor", nargs="+", default=MACHINES)
    parser.add_argument("--policy", nargs="+", default=["eq25"],
                        help="a schedule that brings an estimator runs on that alone")  # fmt: skip
    parser.add_argument("--estimator", nargs="+", default=("smo", "flux", "coupled"),
                        choices=tuple(ESTIMATORS))  # fmt: skip
    parser.add_argument("--suite", nargs="+", default=KNOWN, choices=KNOWN)
    parser.add_argument("--action", nargs="+", default=ACTIONS, choices=(*ACTIONS, "stop"))
    parser.add_argument("--seed", type=int, default=977)
    parser.add_argument("--size", type=int, default=65, help="scenarios of a suite")
    parser.add_argument("--out", type=Path, help="file for the result")
    args = parser.parse_args()
    found = []
    for motor in map(Motor.load, args.motor):
        for name in args.policy:
            policy = make_policy(name, motor)
            own = {design_for(policy, DriveDesign(estimator=e)).estimator for e in args.estimator}
            for estimator in sorted(own):
                found += rows_of(motor, policy, DriveDesign(estimator=estimator), args)
    show(found)
    if args.out is not None:
        record = {"seed": args.seed, "size": args.size, "suites": list(args.suite)}
        record |= {"versions": versions(), "found": found}
        text = json.dumps(record, default=float).replace("NaN", "null")
        write_atomic(args.out, text + "\n")


if __name__ == "__main__":
    main()
