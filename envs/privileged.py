"""True quantities for a critic. No policy may see them: they are not part of the observation.

Quantities with a sign count as positive in the direction of motion, as in the observation.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import TRUTH_NAMES, Array, sim_truth
from sensorless.envs.scenarios.scenario import LOST_TIME, Scenarios
from sensorless.machine.motor import Motor

Values = NDArray[np.float32]

BOUND = 10.0
"""All values are clipped to +-BOUND."""


@dataclass(frozen=True)
class Privileged:
    """One column."""

    name: str
    scale: str
    """What the value 1 stands for."""
    doc: str


_TRUTH = {
    "err": Privileged(
        "theta_e_err", "30 degrees", "angle error of the blend, mean of the decision"
    ),
    "err_hfi": Privileged(
        "theta_e_err_hfi", "30 degrees", "angle error of the injection estimator, mean"
    ),
    "err_smo": Privileged(
        "theta_e_err_smo", "30 degrees", "angle error of the observer in use, mean"
    ),
    "omega_m_dev": Privileged("omega_m_dev", "10 % of rated speed", "speed minus the twin's, mean"),
    "tau_dev": Privileged("tau_dev", "rated torque", "torque minus the twin's, mean"),
    "tau": Privileged("tau", "rated torque", "true torque, mean"),
    "tau_load": Privileged("tau_load", "rated torque", "load torque; positive brakes"),
    "omega_m": Privileged("omega_m", "rated speed", "true speed"),
    "u_dc": Privileged("u_dc", "10 % of nominal", "DC-link voltage minus the nominal one"),
    "err_count": Privileged(
        "lost_count", "lost", "time spent beyond the limit of the angle error, over that until lost"
    ),
}
MOVING = tuple(_TRUTH[name] for name in TRUTH_NAMES)
"""What ``core/sim/truth.h`` reads from a running drive."""
FIXED = (
    Privileged("R_s", "25 %", "plant's resistance over the controller's, minus 1"),
    Privileged("L_q_hat", "10 %", "observer's q inductance over its design value, minus 1"),
    Privileged("psi_f", "5 %", "magnet strength over its nominal value, minus 1"),
    Privileged("J", "factor e", "logarithm of inertia over its nominal value"),
    Privileged("cross_hat", "40 %", "cross-coupling compensation over its design value, minus 1"),
    Privileged("dead_time", "nominal", "dead time over its nominal value"),
    Privileged("noise", "0.1 % of rated current", "current noise, RMS"),
    Privileged("gain", "1 %", "gain of current channel a minus that of b"),
    Privileged("offset", "1 % of rated current", "offset of the current channels, magnitude"),
)
PRIVILEGED = MOVING + FIXED
N_PRIVILEGED = len(PRIVILEGED)


def fixed(s: Scenarios, motor: Motor) -> Values:
    """Columns of ``FIXED`` (n, len(FIXED)): what does not change during an episode."""
    dead_time = s.dead_time / motor.dead_time if motor.dead_time > 0.0 else s.dead_time * 0.0
    columns = (
        (s.R_s - 1.0) / 0.25,
        (s.L_q_hat - 1.0) / 0.10,
        (s.psi_f - 1.0) / 0.05,
        np.log(s.J),
        (s.cross_hat - 1.0) / 0.40,
        dead_time,
        s.noise / (0.001 * motor.i_rated),
        (s.gain[:, 0] - s.gain[:, 1]) / 0.01,
        np.hypot(s.offset[:, 0], s.offset[:, 1]) / (0.01 * motor.i_rated),
    )
    return np.stack(columns, axis=-1).astype(np.float32)


def privileged(sims: Array, constant: Values, motor: Motor) -> Values:
    """All columns (n, N_PRIVILEGED) after a decision or at a start.

    Parameters
    ----------
    sims : array of SIM, shape (n,)
    constant : array, shape (n, len(FIXED))
        From `fixed`.
    motor : Motor
    """
    out: Values = np.empty((len(sims), N_PRIVILEGED), dtype=np.float32)
    sim_truth(sims, motor.u_dc, _scale(motor), BOUND, out)
    np.clip(constant, -BOUND, BOUND, out=out[:, len(MOVING) :])
    return out


@lru_cache(maxsize=8)
def _scale(motor: Motor) -> Values:
    """Factors of ``MOVING``."""
    deg_30, speed = 6.0 / np.pi, motor.n_p / motor.omega_rated
    tau, count = 1.0 / motor.tau_rated, motor.T_s / LOST_TIME
    factors = {
        "err": deg_30,
        "err_hfi": deg_30,
        "err_smo": deg_30,
        "omega_m_dev": 10.0 * speed,
        "tau_dev": tau,
        "tau": tau,
        "tau_load": tau,
        "omega_m": speed,
        "u_dc": 10.0 / motor.u_dc,
        "err_count": count,
    }
    return np.array([factors[name] for name in TRUTH_NAMES], dtype=np.float32)
