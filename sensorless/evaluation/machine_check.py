"""Check of a machine: examined on paper, then simulated briefly under a schedule."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sensorless.design.derived import DIP, MUCH_DIP, derive, load_dip
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import LOST_ANGLE_DEG
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import evaluate
from sensorless.evaluation.idle import idle_swing
from sensorless.evaluation.metrics.held import BAND_PCT
from sensorless.machine.motor import Motor
from sensorless.policy import Policy
from sensorless.suitability.examine import Examination, examine
from sensorless.suitability.finding import LIMIT, NO, NOTE, Finding

WRONG_FILE = "mismatch"
"""The suite in which the machine is not as its file says."""
SUITES = (
    "stress",
    "handoff",
    "hold",
    "unload",
    "braking",
    "stop",
    "impact",
    "reversal",
    WRONG_FILE,
)
SEED, SIZE = 1, 100
"""Scenarios of a quick run: all that is uncertain, the way between injection and observer, loads at
rest and at low speed that go or drive, rated speed, rated loads at once at any speed, steps through
zero, and a motor file that is wrong."""
LOST = (0.05, 0.2)
"""Lost share of a quick run above which the drive is limited, or unable: with a wrong file limited
only, since a right one is the cure. A smaller share is noted."""
LOOSE = 0.05
"""Share of a quick run, lost or not held, or kept with a slip, above which the drive is limited."""
MEASURE = ": measure resistance, inductances and magnet flux of this motor well"
"""What helps where a wrong file does harm."""
MORE_INERTIA = ": more inertia on the shaft helps; does J count all that the shaft turns?"
"""What helps where the shaft is too light, or where the file says so and is wrong."""
MUCH_DEAD_TIME = 0.5
"""Dead-time voltage over the injected voltage times 1 - L_d/L_q, above which it is named."""
TOLD = 0.99
"""Share of the losses that a drive tells in time, below which that is said."""
IDLE = (0.02, 0.05)
"""Swing of the torque without load, over rated, above which it is noted, and limits: the ripple of
a loaded drive is some 0.01."""
INFEASIBLE = 0.05
"""Share of a quick run that the sensored twin fails too, above which the drive is limited."""


@dataclass(frozen=True)
class QuickRun:
    """A schedule on scenarios of a suite."""

    suite: str
    size: int
    lost: float
    """share of the feasible scenarios"""
    not_held: float
    """share of the feasible scenarios in which lock is kept, but not the speed"""
    infeasible: float
    """share in which the sensored twin itself trips or runs away"""
    torque_dev: float
    """mean torque deviation from the twin where lock is kept, over rated torque"""
    tripped: float = 0.0
    """share of the lost ones that the current limit ended while the angle was right"""
    under: str = "Eq. 25"
    """name of the schedule"""
    slipped: float = 0.0
    """share of the feasible scenarios in which lock is kept, but the angle passed the judge's limit
    for less than its time"""
    alarms: float = 0.0
    """alarms of the drive itself where it holds, but near losses, over the feasible scenarios"""
    told: float = 1.0
    """share of the losses that the drive told in time"""
    twin_swings: float = 0.0
    """share of the feasible scenarios in which the sensored twin itself swings"""


@dataclass(frozen=True)
class Check:
    """Result of a check."""

    examination: Examination
    runs: tuple[QuickRun, ...]
    """one for each of ``SUITES``; none where the examination says no, or for size 0"""
    dip: float = math.nan
    """what a rated load at once dips the speed by, over rated; NaN where there is no drive"""

    @property
    def lost(self) -> str:
        """What the schedule lost of each suite, in a few words."""
        return ", ".join(
            f"{run.suite} {100.0 * run.lost:.0f} %"
            if run.infeasible < 1.0
            else f"{run.suite} not feasible"
            for run in self.runs
        )


def check(motor: Motor, design: DriveDesign, policy: Policy, under: str, size: int = SIZE) -> Check:
    """Examine a machine, and simulate it unless the verdict is no; ``size`` 0: examine only.

    ``under``: name of the policy in what is found.
    """
    dip = math.nan
    try:
        derived = derive(motor, design)
        dip = load_dip(motor, 2.0 * math.pi * derived.speed_hz)
        e = examine(motor, derived.hfi_pll_hz)
    except UserError:  # of no drive at all: say why, whatever its loops are
        e = examine(motor, 1.0)
        if e.verdict.word != "no":
            raise
    if dip > MUCH_DIP or math.isclose(dip, MUCH_DIP):  # the slowest loop, or slower still
        e = replace(e, findings=(*e.findings, _light(motor, dip)))
    if e.verdict.word == "no" or size == 0:
        return Check(e, (), dip)
    runs = tuple(_quick_run(motor, design, policy, under, suite, size) for suite in SUITES)
    limited = any(f.field == "i_max" and f.weight == LIMIT for f in e.findings)
    light = dip > DIP and not math.isclose(dip, DIP)  # else the loop is as designed, and stiffer
    helps = light and not limited  # a heavier shaft is longer at the limit
    found = judged(runs, (MORE_INERTIA if helps else "") + dead_time_hint(motor))
    found += swings_idle(*idle_swing(motor, design, policy), under)
    return Check(replace(e, findings=(*e.findings, *found)), runs, dip)


def swings_idle(swing: float, speed: float, under: str) -> list[Finding]:
    """What a swing without load adds, over rated torque, at a speed over rated; NaN: lost."""
    at = f"without load at {speed:.0%} of rated speed"
    if math.isnan(swing):
        return [Finding(LIMIT, "run", f"the drive under {under} is lost {at}")]
    if swing <= IDLE[0]:
        return []
    text = f"{at} the torque swings by {swing:.1%} of rated (RMS): near zero current nobody knows "
    text += "what dead time takes; a shorter one calms it"
    return [Finding(LIMIT if swing > IDLE[1] else NOTE, "dead_time", text)]


def dead_time_hint(motor: Motor) -> str:
    """Whether dead time may be why a drive swings: near zero current it turns injection's axis."""
    tells = motor.u_inj * (1.0 - motor.L_d / motor.L_q)
    if motor.dead_time_voltage <= MUCH_DEAD_TIME * tells:
        return ""
    return (
        f"; dead time takes {motor.dead_time_voltage:.3g} V of the {tells:.3g} V by which "
        "injection tells the axes: is the file's dead_time that of the inverter?"
    )


def _light(motor: Motor, dip: float) -> Finding:
    text = f"J = {motor.J:g} kg m2: a rated load at once dips the speed by some {dip:.0%} of rated"
    return Finding(NOTE, "J", text + MORE_INERTIA)


def _quick_run(
    motor: Motor, design: DriveDesign, policy: Policy, under: str, suite: str, size: int
) -> QuickRun:
    result = evaluate(motor, design, suite, SEED, size, {under: policy}).policies[under]
    feasible = max(1.0, size * (1.0 - result["infeasible_rate"]))
    causes = result["scenarios"]["lost_cause"]
    kept = np.array([cause is None for cause in causes])
    far = np.array(result["scenarios"]["angle_err_max_deg"]) > LOST_ANGLE_DEG
    tripped = np.array([cause == "current" for cause in causes])
    beyond = np.array([cause is not None and "twin" in cause for cause in causes])
    swings = np.array(result["scenarios"]["twin_swing_pct"], dtype=np.float64) > BAND_PCT
    lock = result["lock_counts"]
    return QuickRun(
        suite, size, result["lost_rate"], result["not_held_rate"], result["infeasible_rate"],
        result["torque_dev_rms"],
        float(np.sum(tripped & ~far)) / max(1.0, float(np.sum(~kept & ~beyond))), under,
        float(np.count_nonzero(kept & far)) / feasible,
        (lock["false_alarms"] - lock["near_losses"]) / feasible,
        lock["detected"] / lock["watched"] if lock["watched"] else 1.0,
        float(np.sum(swings[~beyond])) / feasible,
    )  # fmt: skip


def judged(runs: Sequence[QuickRun], hint: str = MORE_INERTIA) -> list[Finding]:
    """What quick runs under one schedule add to the verdict; ``hint``: what may hold a speed."""
    found = [finding for run in runs for finding in _judged(run)]
    swung = [run for run in runs if run.not_held > 0.0]
    for weight in (LIMIT, NOTE):
        here = [r for r in swung if (r.lost + r.not_held > LOOSE) == (weight == LIMIT)]
        if here:
            text = f"the drive under {here[0].under} keeps its angle, but swings or stays off its "
            text += "speed in " + ", ".join(map(_not_held, here))
            alone = [run.suite for run in here if run.not_held > LOOSE]
            text += hint if any(suite != WRONG_FILE for suite in alone) else ""
            text += MEASURE if alone == [WRONG_FILE] else ""
            found.append(Finding(weight, "run", text))
    return found


def _not_held(run: QuickRun) -> str:
    """Share in which the speed is not held, and what is lost beside it."""
    beside = f" (and loses {run.lost:.0%})" if run.lost > 0.0 else ""
    return f"{run.not_held:.0%} of {run.suite}{beside}"


def _judged(run: QuickRun) -> list[Finding]:
    """What the losses of one quick run add."""
    found, wrong = [], run.suite == WRONG_FILE
    if run.infeasible == 1.0:
        text = f"even with an encoder, the drive fails all of {run.suite}"
        return [Finding(LIMIT, "run", text + MEASURE) if wrong else Finding(NO, "run", text)]
    if run.infeasible > INFEASIBLE:
        text = f"even with an encoder, the drive fails {run.infeasible:.0%} of {run.suite}"
        found.append(Finding(LIMIT, "run", text))
    if run.twin_swings > 0.0:
        text = "the control itself swings: with an encoder too, the speed does by more than "
        text += f"{BAND_PCT:g} % of rated in {run.twin_swings:.0%} of {run.suite}"
        found.append(Finding(LIMIT if run.twin_swings > LOOSE else NOTE, "run", text))
    if run.lost > 0.0:
        text = f"the drive under {run.under} loses {run.lost:.0%} of the feasible scenarios of "
        text += run.suite
        text += f", and tells {run.told:.0%} of them in time" if run.told < TOLD else ""
        if wrong:
            text += MEASURE
        elif run.tripped > 0.5:
            text += ", mostly by i_trip at a right angle: a higher i_trip leaves the current room"
        weight = NOTE if run.lost <= LOST[0] else LIMIT if wrong or run.lost <= LOST[1] else NO
        found.append(Finding(weight, "run", text))
    if run.slipped > 0.0:
        text = f"the drive under {run.under} slips and comes back in {run.slipped:.0%} of the "
        text += f"feasible scenarios of {run.suite} (for a moment its angle is beyond "
        text += f"{LOST_ANGLE_DEG:g} degrees)"
        text += MEASURE if wrong else ""
        found.append(Finding(LIMIT if run.slipped > LOOSE else NOTE, "run", text))
    if run.alarms > 0.0:
        times = f"{100.0 * run.alarms:.{'0f' if run.alarms >= 0.1 else '2g'}}"
        text = f"the drive under {run.under} takes itself for lost {times} times in "
        text += f"100 scenarios of {run.suite} that it holds: lost_lock = restart or stop would act"
        found.append(Finding(LIMIT if run.alarms > LOOSE else NOTE, "run", text))
    return found
