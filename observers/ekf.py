"""Extended Kalman filter over recorded voltages and currents, as an independent estimator.

The state is stator flux, speed and angle; the measurement is the phase currents. The machine's
flux map, saturation included, links the two, so saliency and magnet both reveal the angle:

    d(psi)/dt = u - R_s i,   domega/dt = 0 + noise,   dtheta/dt = omega
    i = P(theta) f(P(-theta) psi),   P a rotation, f the flux map

It uses filterpy, shares nothing with the drive's observers, and does not depend on the sign of an
injection; it is far too slow for a drive. See R. Labbe, Kalman and Bayesian Filters in Python,
chapter 11.
"""

import math

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from sensorless.core.api import Array
from sensorless.core.machine import flux_map_currents
from sensorless.machine.magnetics import Floats, extra_terms, flux, flux_map_record
from sensorless.machine.motor import Motor
from sensorless.observers.drift_design import LEG_SHARE, R_S_ERROR
from sensorless.observers.injection_signal import sample_error
from sensorless.observers.tracking import rated_acceleration
from sensorless.units import wrapped

TURN = np.array([[0.0, -1.0], [1.0, 0.0]])
FLUX_STEP = 1e-6
STEPS = FLUX_STEP * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
UNKNOWN_TORQUE = 0.02
"""Change of the speed that no model tells, over the root of its time and over rated acceleration
[sqrt(s)]. Less errs less on most machines, but at 0.008 a flux map that is wrong makes it slip."""
THETA_0, OMEGA_0 = 0.5, 0.1
"""Standard deviations of the first angle [rad], and of the first speed over the rated one."""


class _Filter(ExtendedKalmanFilter):  # type: ignore[misc]
    """The library's filter, whose prediction adds the model's change to the state."""

    def predict_x(self, u: Array) -> None:
        """Add the change of the state (4, 1)."""
        self.x: Array = self.x + u


class MachineEkf:
    """The filter of one machine.

    Parameters
    ----------
    motor : Motor
        Gives resistance, flux map and PWM period.
    theta, omega : float
        First angle and speed, electrical [rad, rad/s]; the machine is without current.
    """

    def __init__(self, motor: Motor, theta: float, omega: float) -> None:
        self.motor = motor
        self._map, self._extra = flux_map_record(motor.saturation), extra_terms(motor.saturation)
        psi_f = flux(motor.saturation, np.zeros((1, 2)))[0, 0]
        f = self.filter = _Filter(dim_x=4, dim_z=2)
        f.x = np.array([[psi_f * np.cos(theta)], [psi_f * np.sin(theta)], [omega], [theta]])
        # without current the flux points along the rotor: both angles have the same error
        along = np.array([-psi_f * np.sin(theta), psi_f * np.cos(theta), 0.0, 1.0])
        own = np.array([0.01 * psi_f, 0.01 * psi_f, OMEGA_0 * motor.omega_rated, 0.0])
        f.P = THETA_0**2 * np.outer(along, along) + np.diag(own**2)
        T_s = motor.T_s
        u = math.hypot(motor.dead_time_voltage / LEG_SHARE, R_S_ERROR * motor.R_s * motor.i_rated)
        a = rated_acceleration(motor)
        f.Q = np.diag([(T_s * u) ** 2] * 2 + [T_s * (UNKNOWN_TORQUE * a) ** 2, 0.0])
        f.R = np.eye(2) * sample_error(motor) ** 2

    def step(self, u: Floats, i: Floats) -> tuple[float, float]:
        """Use stator voltage u (2,) [V] over the last period and current i (2,) [A] at its end.

        Returns
        -------
        theta_e, omega_e : float
            Estimate at the sample [rad, rad/s].
        """
        f, T_s, R_s = self.filter, self.motor.T_s, self.motor.R_s
        i_hat, slope = self.measured(f.x)
        f.F = np.eye(4)
        f.F[:2] -= T_s * R_s * slope
        f.F[3, 2] = T_s
        change = np.zeros((4, 1))
        change[:2] = T_s * (u[:, None] - R_s * i_hat)
        change[3] = T_s * f.x[2]
        f.predict(change)
        i_hat, slope = self.measured(f.x)
        f.update(i[:, None], lambda _: slope, lambda _: i_hat)
        f.x[3] = wrapped(f.x[3])
        return float(f.x[3, 0]), float(f.x[2, 0])

    def measured(self, x: Array) -> tuple[Array, Array]:
        """Stator current (2, 1) [A] of a state (4, 1), and its Jacobian (2, 4)."""
        c, s = np.cos(x[3, 0]), np.sin(x[3, 0])
        rotate = np.array([[c, -s], [s, c]])
        psi = rotate.T @ x[:2, 0]
        i = flux_map_currents(self._map, self._extra, psi + STEPS)
        gamma = (i[1::2] - i[2::2]).T / (2.0 * FLUX_STEP)
        jacobian = np.zeros((2, 4))
        jacobian[:, :2] = rotate @ gamma @ rotate.T
        jacobian[:, 3] = rotate @ (TURN @ i[0] - gamma @ TURN @ psi)
        return (rotate @ i[0])[:, None], jacobian


def run_ekf(
    motor: Motor, u: Floats, i: Floats, theta: float, omega: float
) -> tuple[Floats, Floats]:
    """Filter a whole log.

    Parameters
    ----------
    u : (n, 2) stator voltage [V] over the period before each sample
    i : (n, 2) stator current at each sample [A]
    theta, omega : first angle and speed, electrical [rad, rad/s]

    Returns
    -------
    theta_e (n,) [rad], omega_e (n,) [rad/s]; NaN from the sample on at which the filter diverges
    """
    ekf = MachineEkf(motor, theta, omega)
    out = np.full((len(u), 2), np.nan)
    with np.errstate(all="ignore"):
        for k in range(len(u)):
            try:
                out[k] = ekf.step(u[k], i[k])
            except (np.linalg.LinAlgError, ValueError):  # its covariance is no longer one
                break
            if not np.isfinite(out[k]).all():
                out[k] = np.nan
                break
    return out[:, 0], out[:, 1]
