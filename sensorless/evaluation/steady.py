"""Holds many drives at constant speed and load: what the angle error settles to."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from sensorless.core.api import SIGNAL_N, Array, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.units import RPM_TO_RAD_S

STEP = 5
"""PWM periods between two readings of the current; odd, so that the injected part averages out."""

Change = Callable[[Array], None]
"""Changes an array of ``SIM`` before the run in ways that no ``DriveDesign`` offers."""


@dataclass(frozen=True)
class Steady:
    """Means over the window of n drives, each array (n,)."""

    err: Floats
    """truth minus blended estimate [rad]"""
    err_std: Floats
    """standard deviation of that error: noise, or an oscillation [rad]"""
    err_hfi: Floats
    """truth minus the injection estimator's angle, compensation included [rad]"""
    err_smo: Floats
    """truth minus the observer's angle [rad]"""
    i: Floats
    """(n, 2) current in the true rotor frame [A]"""
    i_q_hat: Floats
    """torque current as the drive measures it, in its own frame [A]"""
    omega_m: Floats
    """shaft speed [rad/s]"""
    held: Array
    """(n,) bool: kept lock to the end, with the speed within 2 % of rated of its target"""


def constant(motor: Motor, rpm: Floats, tau: Floats, duration: float, seed: int = 0) -> Scenarios:
    """Scenarios at constant speed [r/min] whose load torque [N m] rises from zero from 0.1 s on.

    ``tau`` is the torque of the machine: the load is smaller by the friction at that speed.
    """
    s = Scenarios.nominal(motor, combine(seed, np.arange(len(rpm))), duration)
    s.omega_0[:] = rpm * RPM_TO_RAD_S
    s.omega[:] = s.omega_0[:, None]
    s.t[:, 1] = 0.1
    s.tau[:, 1:] = (tau - motor.B * s.omega_0)[:, None]
    s.tau_rate[:] = motor.tau_rated / 0.5
    return s


def make_ideal(sims: Array) -> None:
    """Make sensors and inverter exact: what is left are the errors of the estimators."""
    sensor = sims["sensor"]
    sensor["noise_rms"], sensor["dead_time_share"] = 0.0, 0.0
    sensor["lsb"], sensor["inv_lsb"] = 1e-6, 1e6
    sims["control"]["control"]["u_dt"] = 0.0
    for field in ("u_dt", "u_dt_i", "loss_max"):  # what the coupled observer expects of it
        sims["control"]["coupled"]["drift"][field] = 0.0


def steady(
    motor: Motor,
    design: DriveDesign,
    rpm: ArrayLike,
    tau: ArrayLike,
    k_s: float,
    *,
    settle: float = 1.5,
    window: float = 0.4,
    change: Change | None = None,
) -> Steady:
    """Hold n drives at (rpm, tau) under a constant weight and average the last ``window``.

    Parameters
    ----------
    rpm, tau : array, shape (n,)
        Shaft speed [r/min] and torque of the machine [N m].
    settle, window : float
        Time before and length of the average [s].
    change : callable, optional
        As ``Change``, e.g. ``make_ideal``.
    """
    speed, torque = np.broadcast_arrays(
        np.asarray(rpm, dtype=np.float64), np.asarray(tau, dtype=np.float64)
    )
    scenarios = constant(motor, speed, torque, settle + window + 0.1)
    sims = SimFactory(motor, design).build(scenarios, twin=False)
    if change is not None:
        change(sims)
    n = len(sims)
    weight, obs = np.full(n, k_s, np.float32), np.zeros((n, SIGNAL_N), np.float32)
    sim_run(sims, round(settle / motor.T_s), weight, obs)
    names = ("err", "err_sq", "err_hfi", "err_smo", "omega_m")
    total, i, i_q_hat, reads = dict.fromkeys(names, np.zeros(n)), np.zeros((n, 2)), np.zeros(n), 0
    for _ in range(max(1, round(window / (STEP * motor.T_s)))):
        sim_run(sims, STEP, weight, obs)
        x = sims["drive"]
        total = {name: total[name] + sims["sums"][name] / STEP for name in names}
        i = i + np.stack([x["y"]["i_d"], x["y"]["i_q"]], axis=-1)
        i_q_hat = i_q_hat + x["x"]["control"]["i"]["q"]
        reads += 1
    mean = {name: total[name] / reads for name in names}
    slow = np.abs(mean["omega_m"] - speed * RPM_TO_RAD_S) > 0.02 * motor.omega_rated / motor.n_p
    return Steady(
        err=mean["err"],
        err_std=np.sqrt(np.maximum(mean["err_sq"] - mean["err"] ** 2, 0.0)),
        err_hfi=mean["err_hfi"],
        err_smo=mean["err_smo"],
        i=i / reads,
        i_q_hat=i_q_hat / reads,
        omega_m=mean["omega_m"],
        held=(sims["lost"] == 0) & ~slow,
    )
