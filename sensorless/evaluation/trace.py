"""Runs one drive under a policy and records every PWM period."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from sensorless.core.api import (
    SIGNAL_N,
    TRACE_NAMES,
    Array,
    lib,
    sim_set_due,
)
from sensorless.core.gains import gain_records
from sensorless.core.runs import Recording
from sensorless.decision import decision_periods, decision_time
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import LOST_ANGLE_DEG, Scenarios, SimFactory
from sensorless.errors import UserError
from sensorless.evaluation.lock import EARLY
from sensorless.evaluation.metrics.held import BAND_PCT, not_held, twin_swing_pct
from sensorless.evaluation.rollout import CAUSES, cause_of, rollouts, twins_alone, weights
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor
from sensorless.policy import Policy, decide_gains, gains_of
from sensorless.units import RAD_S_TO_RPM, wrapped

Trace = dict[str, Array]
"""Columns of ``TRACE_NAMES`` (``core/sim/trace.h``), each (periods,): SI units, rad, rad/s.
Beside them ``lost``, bits of the verdict in every row, for a lost drive with its twin's to the end
of the scenario; ``twin_fails``, when the twin trips or runs away [s], else infinity; ``judged``, 1
after the verdict; ``not_held``, 1 if an evaluation counts the run so; ``twin_swings``, 1 if the
twin itself swings by as much; ``alarm``, 1 while the drive's own tests tell lost lock;
``recovering``, 1 while it seeks its rotor after that or has stopped; ``fault``, the drive's fault
bits; ``reason``, bits of the tests that failed in alarms so far. The last four are as of the end of
a decision."""
TESTS = {
    "EMF": lib.LOCK_EMF,
    "speed": lib.LOCK_SPEED,
    "current": lib.LOCK_CURRENT,
    "answer": lib.LOCK_ANSWER,
    "stall": lib.LOCK_STALL,
}
"""Tests of lost lock, ``docs/lock.md``: word and bit of ``reason``."""

MOST_PERIODS = 5_000_000


def trace(
    policy: Policy,
    scenario: Scenarios,
    motor: Motor,
    design: DriveDesign,
    change: Callable[[Array], None] | None = None,
    *,
    go_on: bool = False,
) -> Trace:
    """Run one scenario beside its sensored twin.

    ``change`` may alter the array of ``SIM`` before the start in ways that no design offers. A lost
    drive stops; with ``go_on`` it runs to the end, or until it is so fast that numbers overflow.

    Raises
    ------
    UserError
        There is not exactly one scenario, it is too long, or as ``rollout.weights``.
    """
    if len(scenario) != 1:
        raise UserError(f"scenario: {len(scenario)} rows; trace one at a time")
    factory = SimFactory(motor, design)
    sim = factory.build(scenario, sensored=policy.sensored, settings=policy.settings)
    if change is not None:
        change(sim)
    if not 1 <= sim["k_end"][0] <= MOST_PERIODS:
        raise UserError(
            f"duration: {scenario.duration[0]:g} s; give {motor.T_s:g} s, one PWM period, to "
            f"{MOST_PERIODS * motor.T_s:g} s"
        )
    sim["go_on"] = go_on
    obs = np.zeros((1, SIGNAL_N), dtype=np.float32)
    run = Recording(sim, obs)
    policy.reset(1)
    own, counts = [], []
    periods, ranges = decision_periods(motor), gains_of(policy)
    gains = gain_records(sim, ranges, decision_time(motor))
    while (go_on or not run.lost) and not run.at_end:
        k_s = float(weights(policy, obs.copy(), sim)[0])
        if ranges:
            decide_gains(policy, obs.copy(), gains)
            for period in range(periods):
                sim_set_due(sim, gains, period, periods)
                counts.append(run.advance(1, k_s))
                own.append(run.status())
        else:
            counts.append(run.advance(periods, k_s))
            own.append(run.status())
    sound = np.isfinite(run.rows).all(axis=1)
    table = run.rows if sound.all() else run.rows[: np.argmin(sound)]
    out = {name: table[:, j] for j, name in enumerate(TRACE_NAMES)}
    of_rows = np.repeat(np.array(own), counts, axis=0)[: len(table)]
    for name in (name for name in out if name.startswith("theta_e_err")):
        far = np.abs(out[name]) > np.pi  # of a drive so fast that the core no longer wraps it
        out[name][far] = wrapped(out[name][far])
    lost, fails = int(sim["lost"][0]), np.inf
    if lost:
        twin = twins_alone(factory, scenario, policy.settings, change)
        lost |= int(twin["lost"][0]) & CAUSES["twin"]
        fails = motor.T_s * twin["k_lost"][0] if lost & CAUSES["twin"] else np.inf
    out["lost"], out["twin_fails"] = np.full(len(table), lost), np.full(len(table), fails)
    out["judged"] = np.arange(len(table)) >= (sim["k_lost"][0] or len(table))
    out["alarm"], out["recovering"] = of_rows[:, 0] != 0, of_rows[:, 1] != 0
    out["fault"], out["reason"] = of_rows[:, 2], of_rows[:, 3]
    loose, swings = False, False
    if not lost and change is None:
        (r,) = rollouts(policy, scenario, factory)
        loose, swings = not_held(r)[0] == 1.0, twin_swing_pct(r)[0] > BAND_PCT
    out["not_held"], out["twin_swings"] = np.full(len(table), loose), np.full(len(table), swings)
    return out


def lost_cause(t: Trace) -> str | None:
    """Why the drive stopped before its end, in words; None if it did not."""
    return cause_of(int(t["lost"][-1]))


def without_injection(t: Trace) -> Array:
    """Torque as the mean of two successive samples [N m], (periods,)."""
    return np.asarray(0.5 * (t["tau"] + np.concatenate([t["tau"][:1], t["tau"][:-1]])))


def outcome(t: Trace) -> str:
    """How the run ended, in words: kept lock, perhaps narrowly, lost and why, or not feasible."""
    cause = lost_cause(t)
    if cause is None:
        doubts = " and ".join(_doubts(t))
        return f"kept lock, but {doubts}" if doubts else "kept lock"
    if int(t["lost"][-1]) & CAUSES["twin"]:
        fails = f"the drive with an encoder trips or runs away after {t['twin_fails'][-1]:.2f} s"
        return f"not feasible: {fails}"
    return f"lost ({cause}){_noticed(t)}"


MISSED, MISSED_FOR, MISSED_AFTER = 0.1, 0.1, 1.0
"""Distance from the target over it, as a mean over so long at the end [s], that is told, and for
how long the target stood before [s]."""


def _doubts(t: Trace) -> Iterator[str]:
    """What speaks against a drive that kept lock, in words: its angle, its alarm, its speed."""
    far = (np.abs(t["theta_e_err"]) > np.deg2rad(LOST_ANGLE_DEG)) & (t["starting"] == 0.0)
    if far.any():
        ms = 1e3 * int(far.sum()) * float(t["t"][-1] - t["t"][0]) / max(len(far) - 1, 1)
        told = f"{ms:.0f}" if ms >= 10.0 else f"{ms:.2g}"
        yield f"the angle error passed {LOST_ANGLE_DEG:g}° for {told} ms in all"
    if t["alarm"].any():
        failed = ", ".join(name for name, bit in TESTS.items() if int(t["reason"][-1]) & bit)
        yield f"its own alarm came at {t['t'][t['alarm']][0]:.3f} s ({failed})"
    if missed := list(_missed(t)):
        yield from missed
    elif t["not_held"].any():
        yield f"the speed swings, or stays away, by more than {BAND_PCT:g} % of rated (not held)"
    if t["twin_swings"].any():
        yield f"the control itself swings: with an encoder too by more than {BAND_PCT:g} % of rated"


def _missed(t: Trace) -> Iterator[str]:
    """A speed that is far from its target at the end of a run, and that of the twin, in words."""
    last = t["t"] >= t["t"][-1] - MISSED_FOR
    target = RAD_S_TO_RPM * t["omega_m_ref"][t["t"] >= t["t"][-1] - MISSED_AFTER]
    here, twin = (RAD_S_TO_RPM * np.mean(t[x][last]) for x in ("omega_m", "omega_m_twin"))
    stood = np.ptp(target) == 0.0 and t["t"][-1] >= MISSED_AFTER
    if stood and abs(here - target[-1]) > MISSED * abs(target[-1]) > 0.0:
        yield (
            f"the speed is {here:.0f} of {target[-1]:.0f} r/min at the end, with an encoder "
            f"{twin:.0f}"
        )


def cut_short(t: Trace, duration: float) -> str | None:
    """Why a run with ``go_on`` ends before ``duration`` [s], in words; None if it does not."""
    end = float(t["t"][-1])
    if len(t["t"]) < 2 or end > duration - 1.5 * float(t["t"][1]):
        return None
    return (
        f"the run ends at {end:.3f} of {duration:g} s: out of control, the drive turns so fast "
        "that its numbers overflow"
    )


def _end(t: Trace) -> float:
    """Time of the verdict, or of the last row [s]."""
    return float(t["t"][~t["judged"]][-1])


def _noticed(t: Trace) -> str:
    """What the drive did about it, in words."""
    if not t["judged"].any():
        return ""
    near = t["alarm"] & (t["t"] > _end(t) - EARLY)
    if not near.any():
        return ", unnoticed"
    ms = 1e3 * (float(t["t"][near][0]) - _end(t))
    text = f", alarm {abs(ms):.0f} ms {'after' if ms > 0.0 else 'before'} the verdict"
    back = np.flatnonzero(t["recovering"])
    if not len(back):
        return text
    if back[-1] == len(t["t"]) - 1:
        return f"{text}, not in control at the end"
    return f"{text}, in control again after {1e3 * (t['t'][back[-1] + 1] - _end(t)):.0f} ms"


def write_csv(t: Trace, path: Path) -> None:
    """Write all columns of a trace, one row per PWM period."""
    names = [name for name in t if name in TRACE_NAMES]
    lines = [",".join(names)]
    lines += [",".join(f"{x:.9g}" for x in row) for row in np.stack([t[n] for n in names], axis=-1)]
    write_atomic(path, "\n".join(lines) + "\n")


def mean_of_two(x: Array) -> Array:
    """Mean of two successive samples: without the injected part."""
    return np.asarray(0.5 * (x + np.concatenate([x[:1], x[:-1]])))
