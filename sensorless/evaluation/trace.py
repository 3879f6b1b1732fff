"""Runs one drive under a policy and records every PWM period."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from sensorless.core.api import SIGNAL_N, TRACE_NAMES, Array, sim_set_gain, sim_signals, sim_trace
from sensorless.core.gains import due, gain_records
from sensorless.decision import decision_periods, decision_time
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.errors import UserError
from sensorless.evaluation.rollout import CAUSES
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor
from sensorless.policy import Policy, decide, decide_gains, gains_of

Trace = dict[str, Array]
"""Columns of ``TRACE_NAMES`` (``core/sim/simulate.h``), each (periods,): SI units, rad, rad/s."""

MOST_PERIODS = 5_000_000


def trace(
    policy: Policy,
    scenario: Scenarios,
    motor: Motor,
    design: DriveDesign,
    change: Callable[[Array], None] | None = None,
) -> Trace:
    """Run one scenario beside its sensored twin.

    ``change`` may alter the array of ``SIM`` before the start in ways that no design offers.

    Raises
    ------
    UserError
        There is not exactly one scenario, or it is too long.
    """
    if len(scenario) != 1:
        raise UserError(f"scenario: {len(scenario)} rows; trace one at a time")
    sim = SimFactory(motor, design).build(
        scenario, sensored=policy.sensored, settings=policy.settings
    )
    if change is not None:
        change(sim)
    if not 1 <= sim["k_end"][0] <= MOST_PERIODS:
        raise UserError(
            f"duration: {scenario.duration[0]:g} s; give more than 0 and at most "
            f"{MOST_PERIODS * motor.T_s:g} s"
        )
    obs = np.zeros((1, SIGNAL_N), dtype=np.float32)
    sim_signals(sim, obs)
    policy.reset(1)
    rows = []
    periods, ranges = decision_periods(motor), gains_of(policy)
    gains = gain_records(sim, ranges, decision_time(motor))
    while sim["lost"][0] == 0 and sim["k"][0] < sim["k_end"][0]:
        k_s = float(decide(policy, obs.copy(), sim)[0])
        if ranges:
            decide_gains(policy, obs.copy(), gains)
            for period in range(periods):
                for g in due(period, periods, len(ranges)):
                    sim_set_gain(sim, gains, g)
                rows.append(sim_trace(sim, 1, k_s))
        else:
            rows.append(sim_trace(sim, periods, k_s))
        sim_signals(sim, obs)
    table = np.concatenate(rows)
    out = {name: table[:, j] for j, name in enumerate(TRACE_NAMES)}
    out["lost"] = np.full(len(table), sim["lost"][0])
    return out


def lost_cause(t: Trace) -> str | None:
    """Why the drive stopped before its end, in words; None if it did not."""
    bits = int(t["lost"][-1])
    return "+".join(name for name, bit in CAUSES.items() if bits & bit) or None


def outcome(t: Trace) -> str:
    """How the run ended, in words: kept lock, lost and why, or not feasible."""
    cause = lost_cause(t)
    if cause is None:
        return "kept lock"
    if int(t["lost"][-1]) & CAUSES["twin"]:
        return (
            f"not feasible: the drive with an encoder trips or runs away after {t['t'][-1]:.2f} s"
        )
    return f"lost ({cause})"


def write_csv(t: Trace, path: Path) -> None:
    """Write all columns of a trace, one row per PWM period."""
    names = [name for name in t if name != "lost"]
    lines = [",".join(names)]
    lines += [",".join(f"{x:.9g}" for x in row) for row in np.stack([t[n] for n in names], axis=-1)]
    write_atomic(path, "\n".join(lines) + "\n")
