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
        L_q / L_d is below ``LEAST``, as the file has them or as its [saturation] makes them at zero
        current; the message has both values.
    """
    _require(motor, motor.L_d, motor.L_q, "")
    psi = flux(motor.saturation, np.zeros((1, 2)))
    with np.errstate(divide="ignore"):  # of numbers that no machine has
        L = 1.0 / inverse_inductance(motor.saturation, psi)[0].diagonal()  # no L_dq at psi_q = 0
    _require(motor, L[0], L[1], "[saturation] at zero current: ")


def _require(motor: Motor, L_d: float, L_q: float, source: str) -> None:
    if L_q >= LEAST * L_d:
        return
    both = f"{source}L_d = {L_d:.6g} H, L_q = {L_q:.6g} H"
    if L_d > LEAST * L_q:
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
