"""Everything at random: ``stress-1``, which training draws from, and ``stress``."""

import numpy as np

from sensorless.envs.counter_random import Chosen, Draws, Floats, Seeds
from sensorless.envs.scenarios.ranges import (
    EMF_5,
    EMF_7,
    IRON,
    IRON_LOADED,
    MAGNET_SHARE,
    PSI_F_COLD,
    R_S_COLD,
    RIPPLE,
    SALIENCY_6,
    WINDING_K,
    add_errors,
)
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.machine.inverter import LOW_VOLTAGE, U_DIODE, U_TRANSISTOR
from sensorless.machine.magnetics import flux, mtpa
from sensorless.machine.motor import Motor

DURATION = 2.0
"""[s]"""
DETAILS = 2
"""Tells the draws that ``stress`` adds from those of ``stress-1``."""
MISMATCH, LOW_INERTIA = 3, 4
"""The same for ``mismatch`` and ``low-inertia``."""


def stress_1_scenarios(motor: Motor, seeds: Seeds | Chosen) -> Scenarios:
    """Random profiles on a random machine; row i is a function of the seed i alone.

    Half of the drives start at rest, half on a spinning shaft; then two speed targets over the
    whole range of both directions, two loads over the whole range of both signs, and a sag of the
    DC link. Ramps ask for 10 to 60 % of rated torque on the inertia at hand; loads rise within 2 to
    300 ms. Plant and controller differ in resistance, q inductance, magnet, inertia,
    cross-coupling and dead time, and the current sensors have noise, gain and offset errors.
    """
    d = Draws(seeds)
    s = Scenarios.nominal(motor, d.seeds, DURATION)
    omega_rated = motor.omega_m_rated

    add_errors(s, d, motor)

    s.omega_0 = np.where(d.chance(0.5), 0.0, d.uniform(-1.0, 1.0) * omega_rated)
    s.theta_0 = d.uniform(-np.pi, np.pi)
    s.theta_err_0 = d.uniform(-1.0, 1.0) * np.deg2rad(10.0)

    events = (
        ("omega", d.uniform(0.05, 0.30), d.uniform(-1.0, 1.0) * omega_rated),
        ("tau", d.uniform(0.10, 0.50), d.uniform(-1.0, 1.0) * motor.tau_rated),
        ("omega", d.uniform(0.80, 1.30), d.uniform(-1.0, 1.0) * omega_rated),
        ("tau", d.uniform(0.90, 1.60), d.uniform(-1.0, 1.0) * motor.tau_rated),
        ("u_dc", d.uniform(0.60, 1.40), d.uniform(0.88, 1.0)),
    )
    _lay_out(s, events)
    inertia = motor.J * s.J
    s.omega_rate = np.broadcast_to(
        (d.uniform(0.10, 0.60) * motor.tau_rated / inertia)[:, None], s.omega_rate.shape
    ).copy()
    rise = np.exp(d.uniform(np.log(0.002), np.log(0.3)))
    s.tau_rate = np.broadcast_to((motor.tau_rated / rise)[:, None], s.tau_rate.shape).copy()
    return s


def stress_scenarios(motor: Motor, seeds: Seeds | Chosen) -> Scenarios:
    """``stress-1`` on a machine and an inverter that hide nothing; docs/suites-trials.md says why.

    The same profiles, inertia, sensors and observer errors, row by row. Resistance and magnet leave
    the controller's values by a tolerance and by their temperature; the magnet is warmed by the
    winding. The EMF has 5th and 7th harmonics, the rotor a second saliency, the iron a loss, the
    transistors and diodes a threshold voltage, and the DC link the ripple of a mains rectifier.
    Below ``LOW_VOLTAGE`` the inverter has MOSFETs, which have none.
    """
    s = stress_1_scenarios(motor, seeds)
    s.detailed[:] = True
    d = Draws(seeds, DETAILS)
    s.R_s, s.psi_f = d.uniform(*R_S_COLD), d.uniform(*PSI_F_COLD)
    s.winding_K = d.uniform(*WINDING_K)
    s.magnet_K = d.uniform(*MAGNET_SHARE) * s.winding_K
    s.emf_5, s.emf_7 = d.uniform(-EMF_5, EMF_5), d.uniform(-EMF_7, EMF_7)
    s.saliency_6 = d.uniform(-SALIENCY_6, SALIENCY_6)
    s.p_iron = d.uniform(*IRON) * _drawn_iron(motor) * motor.tau_rated * motor.omega_m_rated
    bipolar = motor.u_dc >= LOW_VOLTAGE
    s.u_transistor, s.u_diode = bipolar * d.uniform(*U_TRANSISTOR), bipolar * d.uniform(*U_DIODE)
    s.ripple, s.ripple_phase = d.uniform(*RIPPLE), d.uniform(-np.pi, np.pi)
    s.ripple_hz = np.where(d.chance(0.5), 300.0, 360.0)
    return s


def _drawn_iron(motor: Motor) -> float:
    """Iron loss without load over what ``IRON`` says, so that load keeps it within ``IRON_LOADED``.

    It grows with the square of the flux linkage, by 11 times to rated current with much reluctance.
    """
    i = mtpa(motor)
    size, psi = np.hypot(*i.T), np.hypot(*flux(motor.saturation, i).T)
    grows = (float(np.interp(motor.i_rated, size, psi)) / motor.psi_f) ** 2
    return min(1.0, IRON_LOADED / (IRON[1] * grows))


def mismatch_scenarios(motor: Motor, seeds: Seeds | Chosen) -> Scenarios:
    """``stress-1`` on a machine that the controller knows badly.

    Resistance 0.7 to 2 and magnet 0.85 to 1.06 of the controller's, the observer's L_q 0.6 to 1.35
    of its design, cross-coupling compensated 0 to 1.8 times.
    """
    s, d = stress_1_scenarios(motor, seeds), Draws(seeds, MISMATCH)
    s.R_s, s.psi_f = d.uniform(0.7, 2.0), d.uniform(0.85, 1.06)
    s.L_q_hat, s.cross_hat = d.uniform(0.6, 1.35), d.uniform(0.0, 1.8)
    return s


def low_inertia_scenarios(motor: Motor, seeds: Seeds | Chosen) -> Scenarios:
    """``stress-1`` on 15 to 50 % of the inertia that the drive was designed for, with its ramps."""
    s = stress_1_scenarios(motor, seeds)
    light = np.exp(Draws(seeds, LOW_INERTIA).uniform(np.log(0.15), np.log(0.5)))
    s.omega_rate *= (s.J / light)[:, None]
    s.J = light
    return s


def _lay_out(s: Scenarios, events: tuple[tuple[str, Floats, Floats], ...]) -> None:
    """Sort the events (what, when, target) of every row by time and fill the profile's segments."""
    times = np.stack([when for _, when, _ in events], axis=-1)
    order = np.argsort(times, axis=-1, kind="stable")
    rows = np.arange(len(s))
    s.omega[:] = s.omega_0[:, None]
    for column in range(len(events)):
        which = order[:, column]
        s.t[:, column + 1] = times[rows, which]
        for j, (what, _, target) in enumerate(events):
            hit = which == j
            getattr(s, what)[hit, column + 1 :] = target[hit, None]


def nominal_scenarios(motor: Motor, seeds: Seeds, *_: object) -> Scenarios:
    """The profiles of ``stress-1`` on a drive that knows its machine and has good sensors."""
    s = stress_1_scenarios(motor, seeds)
    exact = Scenarios.nominal(motor, seeds, 1.0)
    for name in (
        "R_s",
        "L_q_hat",
        "psi_f",
        "J",
        "cross_hat",
        "dead_time",
        "noise",
        "gain",
        "offset",
    ):
        setattr(s, name, getattr(exact, name))
    s.u_dc[:] = 1.0
    return s
