"""What drives notice of lost lock, and whether they come back: every suite, estimator and action.

    python studies/lock_study.py [--motor NAME ...] [--estimator NAME ...] [--suite NAME ...]

A policy with `lost_lock` report and restart. Prints for each machine, estimator and action what
`sensorless evaluate` writes of lost lock, over all suites together. Action `truth` is restart with
the true angle and speed at each moment at which the drive takes control again: losses that it does
not bring back are not the search's, the observer cannot carry that load. Allowed is what the load
allows: a drive with the true angle from the alarm on, and the torque of ``i_max``, would be back in
time. Kept: of the drives that ``report`` loses, those that ``restart`` has back in time, lost or
not. With --out the result is written to a file.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.core.api import Array, lib
from sensorless.core.gains import Values
from sensorless.decision import decision_time
from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SUITES, SuiteRows
from sensorless.errors import in_one_line
from sensorless.evaluation.lock import BACK_IN, BAND, IN_TIME, LOCK, STAYS, in_control, lock_summary
from sensorless.evaluation.rollout import are_feasible, at_a_time, rollouts
from sensorless.files import check_writable, write_record
from sensorless.machine.magnetics import torque
from sensorless.machine.motor import Motor
from sensorless.plain_json import plain
from sensorless.policies.registry import make_policy
from sensorless.policy import GainPolicy, Policy, Signals, decide, design_for, gains_of
from sensorless.versions import versions

ACTIONS = ("report", "restart", "truth")
KNOWN = tuple(name for name in SUITES if name not in ("starts", "machines"))
"""Suites of one machine whose drives know their angle at first."""
MACHINES = ("paper", "ipmsm_2200w", "pmsyrm_5600w", "brusa_hsm1")


def largest_torque(motor: Motor) -> float:
    """Torque of a current vector of ``i_max`` at its best angle [N m]."""
    angle = np.radians(np.arange(90.0, 181.0))
    i = motor.i_max * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return float(np.max(torque(motor, i)))


class Ideal:
    """Least time from the alarm until n drives with the true angle would be back.

    Load and friction act on drive and twin alike, so the distance of their speeds, g, changes with
    the torques alone: J dg/dt = tau - tau_twin. It falls fastest at tau = -sign(g) tau_max.
    """

    def __init__(self, motor: Motor, n: int) -> None:
        self._tau, self._step = largest_torque(motor), decision_time(motor)
        self._band = BAND * motor.omega_rated / motor.n_p
        self._gap, self._alarms = np.full(n, np.nan), np.zeros(n, dtype=np.int64)
        self.need_s = np.full(n, np.inf)
        """(n,) from the last alarm before the verdict, or the first after it [s]"""
        self._since = np.zeros(n)

    def look(self, sims: Array) -> None:
        """Take in the drives (n,) after a decision."""
        told, twin = sims["drive"]["x"]["lock"]["alarms"], sims["twin"]["y"]
        side = np.sign(self._gap)
        with np.errstate(invalid="ignore"):
            self._gap -= (self._tau * side + twin["tau"]) * sims["plant"]["inv_J"] * self._step
            self._since += self._step
            back = (np.abs(self._gap) <= self._band) | (np.sign(self._gap) == -side)
        new = (told > self._alarms) & ((sims["lost"] == 0) | np.isnan(self._gap))
        gap = sims["drive"]["y"]["omega_m"] - twin["omega_m"]
        self._gap = np.where(new, gap, self._gap)
        self._since = np.where(new, 0.0, self._since)
        first = np.where(np.abs(gap) <= self._band, 0.0, np.inf)
        self.need_s = np.where(new, first, np.where(back, np.minimum(self.need_s, self._since),
                                                    self.need_s))  # fmt: skip
        self._alarms[:] = told


class Slow:
    """Which of n drives that are not lost were not back in time after one of their alarms."""

    def __init__(self, motor: Motor, n: int) -> None:
        self._band, self._step = BAND * motor.omega_rated / motor.n_p, decision_time(motor)
        self._waits, self._good, self.slow = np.zeros(n), np.zeros(n), np.zeros(n, dtype=np.bool_)
        self._alarms = np.zeros(n, dtype=np.int64)

    def look(self, sims: Array) -> None:
        """Take in the drives (n,) after a decision."""
        alarms = sims["drive"]["x"]["lock"]["alarms"]
        new = alarms > self._alarms
        self._alarms[:] = alarms
        self._good = np.where(in_control(sims, self._band), self._good + self._step, 0.0)
        self._waits += np.where(self._waits > 0.0, self._step, 0.0)
        self._waits[new & (self._waits == 0.0)] = self._step
        self.slow |= self._waits > BACK_IN + STAYS
        self._waits[self._good >= STAYS] = 0.0


class Acting:
    """A policy on drives with this action; with ``truth`` they take control again on the truth."""

    sensored = False

    def __init__(self, inner: Policy, action: str, truth: bool, motor: Motor) -> None:
        self.inner, self.name, self.truth, self.motor = inner, inner.name, truth, motor
        self.settings: Mapping[str, Any] = {**inner.settings, "lost_lock": action}
        self.ranges = gains_of(inner)
        self._seeks: NDArray[np.bool_] = np.zeros(0, dtype=np.bool_)
        self.ideal, self.slow = Ideal(motor, 0), Slow(motor, 0)

    def reset(self, n: int) -> None:
        """Nobody seeks."""
        self.inner.reset(n)
        self._seeks = np.zeros(n, dtype=np.bool_)
        self.ideal, self.slow = Ideal(self.motor, n), Slow(self.motor, n)

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """The policy's own."""
        return self.inner.act(obs)

    def act_gains(self, obs: Signals) -> Values:
        """The policy's own, if it sets gains."""
        assert isinstance(self.inner, GainPolicy)
        return self.inner.act_gains(obs)

    def act_knowing(self, obs: Signals, sims: Array) -> NDArray[np.float32]:
        """The policy's own; set drives that have just taken control on the truth."""
        self.ideal.look(sims)
        self.slow.look(sims)
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
    motor: Motor, policy: Acting, design: DriveDesign, suites: list[str], seed: int, size: int
) -> tuple[dict[str, Any], dict[str, Any]]:
    """``lock_summary`` over these suites, and the arrays that it is of."""
    factory = SimFactory(motor, design)
    runs = []
    for suite in suites:
        scenarios = SuiteRows(suite, motor, seed, size).draw()
        some = min(64, at_a_time(scenarios, motor))
        for r in rollouts(policy, scenarios, factory, some, go_on=True):
            lock = {**r.lock, "need_s": policy.ideal.need_s, "slow": policy.slow.slow}
            runs.append((r.lost, r.periods * motor.T_s, lock))
    lost, time = (np.concatenate([run[j] for run in runs]) for j in (0, 1))
    lock = {
        name: np.concatenate([run[2][name] for run in runs]) for name in (*LOCK, "need_s", "slow")
    }
    feasible = are_feasible(lost)
    held = float(time[feasible & (lost == 0)].sum())
    row = {**lock_summary(lock, lost, time), "held_s": round(held)}
    return row, {**lock, "gone": feasible & (lost != 0)}


def with_room(run: dict[str, Any]) -> NDArray[np.bool_]:
    """Losses that are told and have the time to come back."""
    room = run["gone"] & (run["watched_s"] >= IN_TIME) & np.isfinite(run["alarm_s"])
    room &= run["watched_s"] - np.maximum(run["alarm_s"], 0.0) >= BACK_IN + STAYS
    return np.asarray(room)


def allowed(run: dict[str, Any]) -> dict[str, int]:
    """Losses whose load allows to be back in time, and how many of them are."""
    could = with_room(run) & (run["need_s"] <= BACK_IN)
    back = could & (run["back_s"] <= BACK_IN)
    return {"allowed": int(could.sum()), "allowed_recovered": int(back.sum())}


def possible(restart: dict[str, Any], truth: dict[str, Any]) -> dict[str, int]:
    """Losses that the truth brings back in time, and how many of them the drive itself does."""
    room = with_room(restart)
    could, back = (room & (run["back_s"] <= BACK_IN) for run in (truth, restart))
    return {"possible": int(could.sum()), "possible_recovered": int((could & back).sum())}


def kept(report: dict[str, Any], restart: dict[str, Any]) -> dict[str, int]:
    """Losses with ``report`` that have the time, and how many of them ``restart`` has back in time.

    If it does not lose them, after each of their alarms.
    """
    room = with_room(report)
    good = np.where(restart["gone"], restart["back_s"] <= BACK_IN, ~restart["slow"])
    return {"otherwise_lost": int(room.sum()), "kept": int((room & good).sum())}


def rows_of(motor: Motor, policy: Policy, design: DriveDesign, args: Any) -> list[dict[str, Any]]:
    """One row an action."""
    rows, arrays = [], {}
    for action in args.action:
        truth = action == "truth"
        who = Acting(policy, "restart" if truth else action, truth, motor)
        row, arrays[action] = watched(motor, who, design, list(args.suite), args.seed, args.size)
        rows.append({"motor": motor.name, "policy": policy.name, "estimator": design.estimator,
                     "lost_lock": action} | row | allowed(arrays[action]))  # fmt: skip
        if action == "restart" and "report" in arrays:
            rows[-1] |= kept(arrays["report"], arrays["restart"])
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
    for heading in ("of allowed", "of possible", "kept"):
        table.add_column(heading, justify="right")
    for row in found:
        n = row["lock_counts"]
        counts = (n["false_alarms"], n["near_losses"], n["early_alarms"], n["lost"])
        table.add_row(
            *(row[name] for name in ("motor", "policy", "estimator", "lost_lock")),
            *(str(x) for x in (row["held_s"], *counts)),
            f"{100.0 * row['detected_rate']:.1f}",
            f"{row['detect_ms']:.0f}",
            f"{100.0 * row['recovered_rate']:.0f} of {n['could_recover']}",
            f"{row['allowed_recovered']} of {row['allowed']}",
            f"{row['possible_recovered']} of {row['possible']}" if "possible" in row else "",
            f"{row['kept']} of {row['otherwise_lost']}" if "kept" in row else "",
        )
    Console(width=170).print(table)


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
    parser.add_argument("--seed", type=a_seed, default=977)
    parser.add_argument(
        "--size",
        type=a_count,
        default=64,
        help="scenarios of a suite, a square number for envelope",
    )
    parser.add_argument("--out", type=Path, help="file for the result")
    args = parser.parse_args()
    check_writable(args.out)
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
        write_record(args.out, plain(record))


if __name__ == "__main__":
    in_one_line(main)
