"""The q inductance of the coupled observer over the apparent one: how low, and why.

One too large feeds back positively through the torque current, and sensors and iron are uncertain
by more than a tenth, so it is low on purpose. One too low deviates more where the rotor turns far
in a PWM period, and swings where the EMF leans far and injection is slow: docs/coupled-gains.md.
"""

import numpy as np

from sensorless.machine.magnetics import apparent_q_inductance, flux, mtpa
from sensorless.machine.motor import Motor
from sensorless.observers.tracking import HAND_OVER, bandwidth, voltage_drift

LOW = 0.85
"""The q inductance over the apparent one where nothing asks for more."""
TURN, BY_TURN, MOST = 0.16, 1.25, 0.95
"""Angle by which the rotor turns in a PWM period at rated speed beyond which one too low deviates
more [rad], the rise with it, and the most."""
HELD = 0.8
"""Lean that injection holds, over its bandwidth as a share of the hand-over's frequency."""
LEAN, BY_LEAN, RISE = 0.29, 1.5, 0.1
"""Lean beyond that from which the inductance rises, its rise with it, and the most."""
LEARNED, LESS = 0.09, 0.6
"""Largest error of the inductance that is learned from injection, over the file's unsaturated one,
and how much less with the rise: less than what is too low on purpose, which keeps the loop through
the torque current stable."""


def coupled_L_q_bias(motor: Motor) -> float:
    """The larger of two rules: few PWM periods a turn, and ``rise_by_lean``."""
    turn = motor.omega_rated * motor.T_s
    return max(LOW, min(LOW + BY_TURN * (turn - TURN), MOST), LOW + rise_by_lean(motor))


def learned_share(motor: Motor) -> float:
    """Largest error of the q inductance that is learned, over the file's unsaturated one."""
    return LEARNED - LESS * rise_by_lean(motor)


def rise_by_lean(motor: Motor) -> float:
    """Rise of the q inductance, from 0 to ``RISE``, where injection does not hold the lean.

    Only a bandwidth for the dead time counts: one that resistance raises holds no more of it.
    """
    held = HELD * bandwidth(motor, voltage_drift(motor)) / (HAND_OVER * motor.omega_rated)
    return max(0.0, min(BY_LEAN * (lean(motor) - held - LEAN), RISE))


def lean(motor: Motor) -> float:
    """L_q i_q over the auxiliary flux at rated current [1].

    An inductance that is too low by a share s leans the EMF's angle by s times that.
    """
    line = mtpa(motor).T
    i = np.array([[np.interp(motor.i_rated, np.hypot(*line), x) for x in line]])
    L_q = float(apparent_q_inductance(motor, i)[0])
    psi_a = float(flux(motor.saturation, i)[0, 0]) - L_q * i[0, 0]
    return float(L_q * i[0, 1] / psi_a)
