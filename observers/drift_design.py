"""Errors of the voltages that the injection reveals: from the machine to ``drift_params_t``.

docs/coupled-learning.md derives each formula.
"""

import math
from typing import Any

from sensorless.machine.motor import Motor
from sensorless.observers.hfi_design import hf_current
from sensorless.observers.match_design import learning_time
from sensorless.observers.q_inductance import learned_share
from sensorless.observers.smo_design import low_pass
from sensorless.observers.tracking import (
    HAND_OVER,
    MOST_DEAD_TIME,
    dead_time_noise,
    flux_noise,
    voltage_drift,
)

LEG_SHARE = 0.75
"""Dead-time voltage of a leg over that of the voltage vector: three legs make 4/3 of it."""
R_S_ERROR = 0.5
"""Error of the resistance over the file's: copper has half as much again at +130 K."""
LEARNED_R_S = 0.25
"""Largest error of the resistance that is learned, over the file's: copper at +65 K."""
L_Q_ERROR = 0.3
"""Error of the q inductance, over the file's unsaturated one: what the observer takes too low on
purpose, and as much again."""
KNOWN_L_Q = 0.3
"""Share of what is too low on purpose that counts before any error was learned, for the same
reason: half of the largest that is learned."""
CALM = 8.0
"""Torque current below which the voltages are trusted less and the flux is corrected faster, over
``zero_current``: with less, some leg is within that for more than a quarter of the time."""


def zero_current(motor: Motor) -> float:
    """Current of a leg [A] up to which a dead time takes less than its whole voltage.

    Three things make it, added as independent ones: the dead time of a period stops a current of up
    to (2/3) u_dc t_d / L_d, but does not turn it; and injection and pulses move the current through
    zero between the two edges of a leg, from the middle of the period to each edge by
    u_inj T_s / (4 L_d) and, where the current crosses zero with its phase's EMF, by
    sqrt(3)/12 omega psi_f T_s / L_d.
    """
    stopped = 2.0 / 3.0 * motor.u_dc * motor.dead_time / motor.L_d
    injection = 0.5 * hf_current(motor)
    emf = HAND_OVER * motor.omega_rated * motor.psi_f
    pulses = math.sqrt(3.0) / 12.0 * emf * motor.T_s / motor.L_d
    return math.hypot(stopped, injection, pulses)


def trust_without_torque(motor: Motor) -> float:
    """Share of its bandwidth with which the observer follows the flux without torque current.

    The flux of a period is then wrong by ``dead_time_noise`` d instead of ``flux_noise`` sigma.
    With the share sigma / d the angle moves as much in a period as by the sensors under load.
    """
    lost = dead_time_noise(motor)
    return min(1.0, flux_noise(motor) / lost) if lost > 0.0 else 1.0


def design_drift(
    motor: Motor,
    *,
    injection: float,
    damping: float,
    L_q_bias: float,
    u_dt: float,
    inv_i_comp: float,
) -> dict[str, Any]:
    """Fields of ``drift_params_t``.

    Under torque the drift has three causes, with these standard deviations at rated current:
    ``voltage_drift`` v of the dead time, ``R_S_ERROR`` R_s i / psi_f of the resistance, and
    ``L_Q_ERROR`` omega L_q i / (2 zeta psi_f) of the inductance. Dead time also makes the injection
    err, which looks like a resistance, so less of one is believed where dead time is most of both.

    Parameters
    ----------
    injection : float
        Bandwidth of the injection's double pole [rad/s].
    damping : float
        Damping zeta of the flux error, over the electrical frequency.
    L_q_bias : float
        The observer's q inductance over that of the file.
    u_dt, inv_i_comp : float
        Dead-time compensation of the drive: voltage of a leg [V], slope through zero [1/A].
    """
    dead_time = voltage_drift(motor)
    resistance = R_S_ERROR * motor.R_s * motor.i_rated / motor.psi_f
    omega = HAND_OVER * motor.omega_rated
    inductance = L_Q_ERROR * omega * motor.L_q * motor.i_rated / (2.0 * damping * motor.psi_f)
    learned = learned_share(motor)
    known = KNOWN_L_Q * (L_q_bias - 1.0)
    both = dead_time**2 + resistance**2
    share = dead_time**2 / both
    calm = trust_without_torque(motor)
    return {
        "k": injection**2 * motor.T_s,
        "most": 2.0 * dead_time + resistance,
        "res_most": min(LEARNED_R_S / R_S_ERROR, 1.0 - share) * resistance,
        "alpha": low_pass(injection / (2.0 * math.pi), learning_time(motor)),
        "ind_most": learned / L_Q_ERROR * inductance,
        "ind_0": max(-learned, min(known, learned)) / L_Q_ERROR * inductance,
        "inv_omega": 1.0 / omega,
        "ind_share": inductance**2 / both,
        "inv_i_true": 1.0 / zero_current(motor),
        "inv_i": 1.0 / motor.i_rated,
        "dead_share": share,
        "res_share": 1.0 - share,
        "u_dt": u_dt,
        "u_dt_i": u_dt * inv_i_comp,
        "to_loss": LEG_SHARE * motor.psi_f,
        "from_loss": 1.0 / (LEG_SHARE * motor.psi_f),
        "calm": calm,
        "calm_rise": (1.0 - calm) * motor.i_rated / (CALM * zero_current(motor)),
        "loss_max": MOST_DEAD_TIME * motor.dead_time_voltage,
    }
