"""What two details of the printed equations cost: the timing of the injection, and Eq. 26."""

import dataclasses

import numpy as np

from sensorless.core.api import Array
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.steady import make_ideal, steady
from sensorless.evaluation.trace import trace
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.reproduce.case import CORRECTED, PUBLISHED, Case, row_of
from sensorless.reproduce.switching import crossing, torque_span

SPEEDS = (150.0, 350.0, 600.0, 1500.0)


def ample_link(sims: Array) -> None:
    """Make sensors exact, and the DC link high enough to need no field weakening at rated speed."""
    make_ideal(sims)
    sims["profile"]["u_dc"] *= 1.3


def lock_offsets(motor: Motor, scheme: str, delay_cure: bool) -> list[float]:
    """Estimate minus truth [deg] of injection alone at ``SPEEDS`` of a 1500 r/min machine."""
    design = dataclasses.replace(
        PUBLISHED, hfi_scheme=scheme, hfi_delay_cure=delay_cure, speed_hz=1.0
    )
    rpm = np.array(SPEEDS) * motor.n_rated_rpm / 1500.0
    run = steady(motor, design, rpm, np.zeros(len(rpm)), 1.0, change=ample_link)
    return [float(x) for x in np.where(run.held, np.rad2deg(-run.err), np.nan)]


def timing(motor: Motor) -> Case:
    """Where the injection estimator locks without load, for both details of its timing."""
    rows = []
    delay = motor.L_q - motor.L_d
    sample, act = 0.5 * motor.L_q / delay, 1.5 * motor.L_d / delay
    for cure, words in ((False, "injection at the angle of the sample"), (True, "1.5 T_s ahead")):
        columns = [lock_offsets(motor, scheme, cure) for scheme in ("stationary", "rotating")]
        for j, rpm in enumerate(SPEEDS):
            cells = [column[j] for column in columns]
            rows.append(row_of(f"lock offset at {rpm:g} r/min, {words}", "°", "–", cells))
    return Case(
        "timing",
        "Eqs. 1-9: timing of injection and demodulation",
        "injection alone, no load, exact sensors, DC link 30 % higher to avoid field weakening; "
        "published: first difference in the stationary frame, turned by the angle of the second "
        "sample; corrected: second difference in the rotating frame; estimate − truth",
        tuple(rows),
        "A difference of two samples belongs to the middle between them, half a period before the "
        "angle that turns it, and a voltage computed now acts 1.5 periods later. So the lock moves "
        "by −(L_q/2)/(L_q − L_d) and −1.5 L_d/(L_q − L_d) times ωT_s, here "
        f"−{sample:.2f} and −{act:.2f} times.",
    )


def printed(motor: Motor) -> Case:
    """Set Eq. 26 as printed, without wrap, beside the corrected drive."""
    as_printed = dataclasses.replace(PUBLISHED, estimator="unwrapped")
    ramps = suite("paper", motor, 0, 3)[1:2]
    eq25 = make_policy("eq25", motor)

    def worst(design: DriveDesign) -> float:
        err = trace(eq25, ramps, motor, design)["theta_e_err"]
        return float(np.rad2deg(np.max(np.abs(err))))

    def span(design: DriveDesign) -> float:
        slow = dataclasses.replace(design, speed_hz=2.0)
        return torque_span(trace(eq25, crossing(motor, 0), motor, slow, make_ideal), "up")

    drives = (as_printed, CORRECTED)
    return Case(
        "printed",
        "Eq. 26 as printed",
        "the runs of Figs. 13/14, and the crossing under 4 N m with exact sensors and a speed loop "
        "of 2 Hz; published: without wrap",
        (
            row_of("largest angle error of Figs. 13/14", "°", "5", [worst(d) for d in drives], 1),
            row_of("torque peak to peak, blend, up", "N m", "–", [span(d) for d in drives]),
        ),
        "Once a revolution one angle passes ±180° before the other. Meanwhile their weighted sum "
        "without wrap is wrong by k_s turns: only for a period or two, but by half a turn in the "
        "middle of the band. Lock survives that, torque does not. The paper shows nothing like it, "
        "so its drive must wrap; all other figures on this page do.",
    )
