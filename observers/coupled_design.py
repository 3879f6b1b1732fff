"""Coupled observer: from the machine, its inverter and its sensors to ``coupled_params_t``.

docs/coupled-gains.md derives each formula. No constant was fitted on a machine; those below
describe how a drive is used and how exact its parts are.
"""

import math
from dataclasses import dataclass
from typing import Any

from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.motor import Motor
from sensorless.observers.drift_design import CALM, design_drift, zero_current
from sensorless.observers.flux_design import standstill_rate
from sensorless.observers.hfi_design import error_slope
from sensorless.observers.match_design import GAIN_SPEED, design_match
from sensorless.observers.smo_design import low_pass
from sensorless.observers.tracking import (
    HAND_OVER,
    flux_noise,
    injection_bandwidth,
    rated_acceleration,
    resistance_drift,
    tracking,
    voltage_drift,
)

INERTIA_SHARE = 2.0 / 3.0
"""Share of the torque that is fed forward: the mean of 1/3 and 1, for inertias of one to three
times the machine's own."""
LOAD_OVER_SPEED = 2.0
"""Pole of the load estimate over the natural frequency of the speed loop, which must not wait for
the estimate."""
DAMPING = (0.22, 0.3)
"""Least and largest damping of the flux error over its frequency, the electrical one. With less,
what the sensors do to the flux decays too slowly."""
LEAN = 0.3
"""Most that ``LEFT_RESISTANCE`` may lean the angle by without injection, at rated current and the
speed of the hand-over [rad]: a third of what loses the drive."""
RISE = (1.0 / 6.0, 1.0 / 2.0)
"""Errors, over that which a rated load step leaves, at which the bandwidth starts to rise and at
which it has risen by ``RISE_MAX``."""
RISE_MAX = 0.75
RISE_OVER_LOAD = 9.0
"""Low-pass of the error that makes the bandwidth rise, over the load's pole: as fast as the flux
has to be for the speed loop (``LOOP_SHARE`` of ``sensorless.design.derived``)."""
BRAKED = 0.3
"""Lean of the angle by a wrong resistance that the flux correction may make in a generator [rad],
for an error of the whole resistance: for one of a third a third of ``LEAN``."""
BRAKED_LEAST = 0.4
"""Least share of the flux correction in a generator: errors of sensors and magnets must decay."""
MOST_LOAD = 4.0
"""Bound on the estimated load, over the acceleration by rated torque: twice that torque on half the
inertia."""
LEFT_IDLE = 0.5
"""Most that a dead time that is not known may change the flux's length by without torque current,
over psi_f: with more, nothing is left of the flux that an angle could be read from."""
LEAST_FLUX = 0.25
"""Least auxiliary flux that errors are divided by, over psi_f: one that short has no direction to
speak of."""
LAYER_SPEED = 0.05
"""Speed, over rated, at which an uncompensated dead time displaces the flux by one boundary layer:
the sigmoid should saturate on errors that no model explains."""


@dataclass(frozen=True)
class Bandwidths:
    """Frequencies of the coupled observer [rad/s]."""

    flux: float
    """of the voltage model's double pole"""
    load: float
    """of the load's pole"""
    injection: float
    """of the injection's double pole"""


def bandwidths(motor: Motor, speed_hz: float) -> Bandwidths:
    """Steady-state Kalman gains of the two loops, for white noise and random steps.

    Voltage model: ``tracking`` with ``flux_noise``. Injection: ``injection_bandwidth``.

    Parameters
    ----------
    speed_hz : float
        Natural frequency of the speed loop [Hz].
    """
    return Bandwidths(
        flux=tracking(motor, flux_noise(motor)),
        load=load_pole(speed_hz),
        injection=injection_bandwidth(motor),
    )


def load_pole(speed_hz: float) -> float:
    """Pole of the load [rad/s] for a speed loop of this natural frequency [Hz]."""
    return LOAD_OVER_SPEED * 2.0 * math.pi * speed_hz


def damping(motor: Motor) -> float:
    """Damping zeta of the flux error: the largest of ``DAMPING``, or as ``LEAN`` says.

    Without injection a drift by v rad/s, dR i / psi_f of a wrong resistance, leans the angle by
    2 (b + zeta omega) v / omega^2, b the ``standstill_rate``.
    """
    least, most = DAMPING
    omega = HAND_OVER * motor.omega_rated
    lean = 0.5 * LEAN * omega / resistance_drift(motor)
    return max(least, min(most, lean - standstill_rate(motor) / omega))


def brake(motor: Motor) -> float:
    """R_s over half of ``BRAKED`` and T_s, where ``LEAN`` bounds the damping, else 0 [ohm/s]."""
    bound = damping(motor) < DAMPING[1]
    return motor.R_s / (0.5 * BRAKED * motor.T_s) if bound else 0.0


def idle(motor: Motor) -> float:
    """More correction of the flux without torque current, where injection leads [1/s].

    Dead time then pulls at the flux's length with up to ``voltage_drift`` v, and a correction of
    rate c leaves v/c: ``LEFT_IDLE`` asks for c = v / ``LEFT_IDLE``, ``standstill_rate`` has 2 b.
    """
    return max(0.0, voltage_drift(motor) / LEFT_IDLE - 2.0 * standstill_rate(motor))


def layer(motor: Motor) -> float:
    """Thickness of the correction's boundary layer, over the auxiliary flux.

    The larger of two: what an uncompensated dead time displaces the flux by at ``LAYER_SPEED``; and
    what lets the bounded correction at rest, twice ``standstill_rate`` b of it, hold the
    drifts of dead time v and resistance v_R, (v + v_R)/(2 b). Else the flux follows its
    integration.
    """
    dead_time = voltage_drift(motor)
    held = (dead_time + resistance_drift(motor)) / (2.0 * standstill_rate(motor))
    return max(dead_time / (LAYER_SPEED * motor.omega_rated), held)


def flux_at_no_d_current(motor: Motor, line: Floats) -> Floats:
    """psi_d - L_d i_d [Vs] along the operating line (CURVE_N, 2) [A]: what is not linear in i_d."""
    return flux(motor.saturation, line)[:, 0] - motor.L_d * line[:, 0]


def design_coupled(
    motor: Motor,
    line: Floats,
    *,
    at: Bandwidths,
    linear: bool,
    L_q_bias: float,
    u_dt: float,
    inv_i_comp: float,
    floor_rpm: float,
    omega_max: float,
) -> dict[str, Any]:
    """Fields of ``coupled_params_t``.

    Parameters
    ----------
    line : array, shape (CURVE_N, 2)
        Currents of the operating line [A].
    at : Bandwidths
        Those of ``bandwidths``, or others.
    linear : bool
        Correct the flux in proportion to its error, without the sigmoid.
    L_q_bias : float
        The observer's q inductance over that of the file.
    u_dt, inv_i_comp : float
        Dead-time compensation of the drive: voltage of a leg [V], slope through zero [1/A].
    floor_rpm : float
        Speed below which the flux is not used without injection [r/min].
    omega_max : float
        Bound on the speed estimate, electrical [rad/s].
    """
    acceleration = rated_acceleration(motor)
    left = acceleration / at.flux**2
    low, high = (share * left for share in RISE)
    rise = min(at.flux, RISE_OVER_LOAD * at.load)
    return {
        "R_s": motor.R_s,
        "L_d": motor.L_d,
        "psi_d": {"y": flux_at_no_d_current(motor, line)},
        "psi_sq_min": (LEAST_FLUX * motor.psi_f) ** 2,
        "gain_0": standstill_rate(motor) * motor.T_s,
        "gain_w": damping(motor) * motor.T_s,
        "brake": brake(motor),
        "brake_least": BRAKED_LEAST if brake(motor) > 0.0 else 0.0,
        "idle": idle(motor) * motor.T_s,
        "inv_i_idle": 1.0 / (CALM * zero_current(motor)) if idle(motor) > 0.0 else 0.0,
        "layer": layer(motor),
        "inv_layer": 0.0 if linear else 1.0 / layer(motor),
        "k_p": motor.T_s * (2.0 * at.flux + at.load),
        "k_i": at.flux**2 + 2.0 * at.flux * at.load,
        "k_l": motor.T_s * at.flux**2 * at.load,
        "k_tau": INERTIA_SHARE * 1.5 * motor.n_p**2 / motor.J,
        "load_max": MOST_LOAD * acceleration,
        "alpha_rise": low_pass(rise / (2.0 * math.pi), motor.T_s),
        "eps_rise": low,
        "rise": RISE_MAX / (high - low),
        "rise_max": RISE_MAX,
        "inv_slope": 1.0 / error_slope(motor.L_d, motor.L_q),
        "k_h": 2.0 * at.injection * motor.T_s,
        "omega_floor": motor.rpm_to_electrical(floor_rpm),
        "omega_max": omega_max,
        "drift": design_drift(
            motor,
            injection=at.injection,
            damping=damping(motor),
            L_q_bias=L_q_bias,
            u_dt=u_dt,
            inv_i_comp=inv_i_comp,
        ),
        "match": design_match(
            motor,
            flux_bandwidth=at.flux,
            injection=at.injection,
            correction=2.0
            * (standstill_rate(motor) + GAIN_SPEED * damping(motor) * motor.omega_rated),
        ),
    }
