"""How the exported drive starts, which depends on whether it can find the rotor of this machine.

``sensorless simulate --start``, the README and ``params.h`` all ask ``knows_poles``.
"""

import math
from string import Template

import numpy as np

from sensorless.core.api import SIGNAL_N, lib, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import Motor
from sensorless.observers.lock_design import ACTIONS, RESTARTS
from sensorless.observers.start_design import knows_poles, spin_speed
from sensorless.units import RPM_TO_RAD_S

FINDS = """\
    drive_init(&drive_params, &drive, 0.0f, 0.0f, 1.0f); /* angle, speed, k_s to start from */
    drive_find_rotor(&drive); /* find the unknown angle, pole and speed */"""
KNOWN = """\
    /* You must know rotor angle [rad] and speed [rad/s], electrical: see below. */
    drive_init(&drive_params, &drive, known_angle(), known_speed(), 1.0f);"""
FINDS_TEXT = """\
After `drive_find_rotor` the drive takes some 20 to 50 ms to find its rotor, at rest or spinning. It
makes no torque meanwhile: keep the load torque below half of rated until `drive.start.phase` is 0.
Leave the call out if the shaft rests and you know its angle within 60 degrees: pass it to
`drive_init`. A shaft that spins needs its exact speed and angle there: near rated speed a wrong
angle turns the EMF, which then drives a current that trips.
`FAULT_POLE` in `drive.fault` means that saturation was too weak to be sure of the north pole."""
KNOWN_TEXT = """\
**The drive cannot find the rotor of this machine at rest.** In the motor file, its
iron saturates little or not along d, so north and south respond alike to a pulse, and
`DRIVE_FINDS_ROTOR` in `params.h` is 0. Do not call `drive_find_rotor` there: it would keep the pole
nearer to its first angle and set `FAULT_POLE`. Pass `drive_init` the angle of a shaft at rest
within 60 degrees, from an alignment or from a sensor; `example/cortex_m4.c` takes
it as `SHAFT_ANGLE` (`make cortex_m4 SHAFT_ANGLE=0.0f`). Half a turn off, a drive may stand
or run slowly for good. `sensorless simulate --start` refuses this machine for the same reason.

To align a free shaft, connect a supply of $align_u V ($align A at rest), plus to phase b and minus
to phases a and c together, until the shaft rests; then plus to a and minus to b and c. It comes to
rest at angle 0 within seconds. The first place takes a rotor off the point where the second would
balance it.

The EMF of a shaft that spins shows its pole. If it turns at $least r/min or more, call
`drive_find_rotor` after `drive_init`; `FAULT_POLE` then says that it was too slow. An angle and a
speed given to `drive_init` would have to be exact: near rated speed a wrong one drives a current
that trips.
With a measured [saturation] in the motor file, the drive may be able to find the pole at rest."""

FLYING = 0.9
"""Share of the voltage that the EMF of a shaft may take when a drive catches it."""
STEPS, ANGLES, CATCH_S = 18, 4, 30e-3
"""Speeds up to that share at which a catch is simulated, angles at each, and how long [s]."""
WRONG = 0.1
"""Error of the speed of a catch that went wrong, over the speed at which the EMF takes all the
voltage."""
LOST = {
    "report": "goes on: stop it or start it again, as the application allows",
    "restart": "takes its\ntorque away for some 20 to 40 ms, seeks the rotor and goes on; after "
    f"{RESTARTS} restarts without\na second of health it stops",
    "stop": "applies no\nvoltage any more until `drive_init`, and sets `FAULT_STOPPED`",
}
"""What a drive does that has lost its rotor, by the setting ``lost_lock``."""
CHANGES = """
Its first answer to a loss is to go on with the coupled observer: that needs no pause."""
"""What a drive on another observer does before it restarts."""
GUESSES = """
Pulses do not show the pole of this machine: a restart of a shaft too slow for its EMF to show it
guesses, and sets `FAULT_POLE`. Stop such a drive, and start it from a known angle."""


def aligning_current(motor: Motor) -> float:
    """Direct current that turns the magnet to itself [A]: rated, or half of the most that does.

    Along the magnet a current i turns it back by psi_f i + (L_d - L_q) i^2 for each radian: from
    psi_f / (L_q - L_d) on reluctance turns the rotor off.
    """
    return min(motor.i_rated, 0.5 * motor.psi_f / (motor.L_q - motor.L_d))


def start_call(motor: Motor) -> str:
    """Lines of C for the README that start the drive."""
    return FINDS if knows_poles(motor) else KNOWN


def start_text(motor: Motor) -> str:
    """What the README says about these lines."""
    if knows_poles(motor):
        return FINDS_TEXT
    i = aligning_current(motor)
    numbers = {"least": f"{spin_speed(motor):.0f}", "align": f"{i:.3g}"}
    return Template(KNOWN_TEXT).substitute(numbers, align_u=f"{1.5 * motor.R_s * i:.3g}")


def caught_share(motor: Motor, design: DriveDesign) -> float:
    """Share of the voltage up to which the simulated drive catches a shaft; 0: none.

    A machine that does not show its pole at rest is tried from `spin_speed` on. Before the drive
    knows the EMF, the EMF drives a current, which a fast machine with little inductance brings
    beyond the over-current limit. Where it does, or where the speed comes out wrong, one step less
    is allowed.
    """
    shares = FLYING * np.arange(1, STEPS + 1) / STEPS
    slow = 0.0 if knows_poles(motor) else spin_speed(motor) / _full_speed(motor)
    below = int(np.searchsorted(shares, slow))
    shares = shares[below:]
    n = len(shares) * ANGLES
    s = Scenarios.nominal(motor, combine(1, np.arange(n)), 1.0)
    s.seek[:], s.theta_0 = True, np.tile(np.pi * np.arange(ANGLES) / ANGLES, len(shares))
    s.omega_0 = np.repeat(shares * _full_speed(motor), ANGLES) * RPM_TO_RAD_S
    s.omega[:] = s.omega_0[:, None]
    sims = SimFactory(motor, design).build(s)
    k_s, obs = np.zeros(n, np.float32), np.zeros((n, SIGNAL_N), np.float32)
    sim_run(sims, round(CATCH_S / motor.T_s), k_s, obs)
    x, full = sims["drive"]["x"], _full_speed(motor) * RPM_TO_RAD_S
    trips = (x["fault"] & lib.FAULT_OVER_CURRENT) != 0
    wrong = np.abs(x["est"]["omega"] / motor.n_p - s.omega_0) > WRONG * full
    bad = (trips | wrong).reshape(-1, ANGLES).any(axis=1)
    steps = max(below + int(bad.argmax()) - 1, 0) if bad.any() else STEPS
    return FLYING * steps / STEPS if steps > below or below == 0 else 0.0


def _full_speed(motor: Motor) -> float:
    """Speed at which the EMF takes all of the voltage [r/min]."""
    return motor.u_dc / math.sqrt(3.0) / motor.psi_f / motor.n_p / RPM_TO_RAD_S


def spin_text(motor: Motor, design: DriveDesign) -> str:
    """What the README says of a shaft that spins when the drive starts again."""
    share = caught_share(motor, design)
    rpm, least = share * _full_speed(motor), spin_speed(motor)
    if share == 0.0:
        return "Let the shaft come to rest first: the drive cannot find its rotor."
    why = f"""where its EMF takes {share:.3g} of the voltage: the drive holds the current
at zero while it seeks, and a faster shaft drives one that trips"""
    if knows_poles(motor):
        return f"The shaft may spin meanwhile, at up to\n{rpm:.0f} r/min, {why}."
    return f"""\
Call `drive_find_rotor` for a shaft that
spins at {least:.0f} to {rpm:.0f} r/min, {why}. Let a
slower one come to rest, and start at its angle."""


def lost_text(action: int, motor: Motor, estimator: str) -> str:
    """What the README says about a lost rotor; ``action`` is one of ``ACTIONS``."""
    name = next(name for name, number in ACTIONS.items() if number == action)
    more = CHANGES if name == "restart" and estimator != "coupled" else ""
    more += GUESSES if name == "restart" and not knows_poles(motor) else ""
    return f"""\
When it loses its rotor, the drive sets `FAULT_LOCK` and {LOST[name]}.
That is `lost_lock={name}`, `.lock.action` in `params.c`; `--set lost_lock=` of `sensorless export`
takes {", ".join(LOST)}.{more}"""


def start_define(motor: Motor) -> str:
    """Line of ``params.h`` that says whether the drive can find its rotor."""
    value = int(knows_poles(motor))
    return f"#define DRIVE_FINDS_ROTOR {value} /* 1: drive_find_rotor finds the pole */"
