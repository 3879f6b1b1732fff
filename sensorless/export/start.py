"""How the exported drive begins: whether this machine lets it find its rotor, in every file alike.

``sensorless simulate --start``, the README and ``params.h`` all ask ``knows_poles``.
"""

from sensorless.machine.motor import Motor
from sensorless.observers.start_design import knows_poles

FINDS = """\
    drive_init(&drive_params, &drive, 0.0f, 0.0f, 1.0f); /* angle, speed, k_s to start from */
    drive_find_rotor(&drive); /* unknown: find angle, pole and speed */"""
KNOWN = """\
    /* Rotor angle [rad] and speed [rad/s], electrical, have to be known: see below. */
    drive_init(&drive_params, &drive, known_angle(), known_speed(), 1.0f);"""
FINDS_TEXT = """\
After `drive_find_rotor` the drive takes some 20 to 50 ms to find its rotor, at rest or spinning,
without torque: keep the load's torque below half of the rated one until `drive.start.phase` is 0.
Leave the call out where angle (within 90 degrees) and speed are known and given to `drive_init`.
Fault bit 8: the machine's saturation was too weak to be sure of the magnet's pole."""
KNOWN_TEXT = """\
**This machine cannot find its rotor from an unknown angle.** Its iron does not saturate along d in
the motor file, so north and south answer a pulse alike, and `DRIVE_FINDS_ROTOR` in `params.h` is 0.
Do not call `drive_find_rotor`: it would keep the pole nearer to its first angle, with fault bit 8.
Give `drive_init` the angle within 90 degrees, from an alignment by direct current or a sensor.
`sensorless simulate --start` refuses this machine for the same reason; with a measured
[saturation] in the motor file the pole may be found."""


def start_call(motor: Motor) -> str:
    """C lines of the README's start."""
    return FINDS if knows_poles(motor) else KNOWN


def start_text(motor: Motor) -> str:
    """What the README says about them."""
    return FINDS_TEXT if knows_poles(motor) else KNOWN_TEXT


def start_define(motor: Motor) -> str:
    """Line of ``params.h``."""
    value = int(knows_poles(motor))
    return f"#define DRIVE_FINDS_ROTOR {value} /* 1: drive_find_rotor tells the poles apart */"
