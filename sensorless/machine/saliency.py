"""Saliency, the difference of the two inductances, by which injection finds the rotor."""

import numpy as np

from sensorless.errors import UserError
from sensorless.machine.magnetics import Floats, flux, inverse_inductance
from sensorless.machine.motor import Motor

LEAST = 1.02
"""L_q / L_d below which no drive is designed: tolerances of 2 % could reverse the saliency."""


def require_saliency(motor: Motor) -> None:
    """Refuse a machine in which injection finds no direction.

    Raises
    ------
    UserError
        L_q / L_d is below ``LEAST``; the message has both values.
    """
    if motor.L_q >= LEAST * motor.L_d:
        return
    both = f"L_d = {motor.L_d:g} H, L_q = {motor.L_q:g} H"
    if motor.L_d > LEAST * motor.L_q:
        raise UserError(
            f"motor {motor.name!r}: {both}; L_q must exceed L_d, with d along the magnet: swap the "
            "two if they are in the wrong places"
        )
    raise UserError(
        f"motor {motor.name!r}: {both}; choose a machine with L_q / L_d of at least {LEAST:g}: one "
        "without saliency (surface magnets) gives injection no angle"
    )


def principal(motor: Motor, i: Floats) -> Floats:
    """Incremental inductances (n, 2) [H] along the magnetic axes, small before large.

    Cross-coupling has turned these axes, see ``cross_angle``. Where the inductance is not positive
    in every direction, the larger one is infinite.
    """
    gamma = inverse_inductance(motor.saturation, flux(motor.saturation, i))
    low, high = np.linalg.eigvalsh(0.5 * (gamma + gamma.swapaxes(1, 2))).T
    with np.errstate(divide="ignore"):
        large = np.where(low > 0.0, 1.0 / low, np.inf)
    return np.stack([1.0 / high, large], axis=-1)
