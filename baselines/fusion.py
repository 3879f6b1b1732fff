"""Kalman fusion: the two angles weighted by the inverse of their error variances.

    r_hfi = (residual_hfi / slope)^2 + floor^2       slope = 1 - L_d / L_q
    r_smo = residual_smo^2 + (bias / |e_hat|)^2
    k_s   = r_smo / (r_hfi + r_smo)

This is the update of a Kalman filter that measures one angle twice without prior knowledge: its
gains are (k_s, 1 - k_s). The residuals are the RMS of the error signals of the two phase-locked
loops, their innovations [rad]. An innovation does not show errors that estimate and measurement
share, so each variance has a second part that follows from physics: cross-coupling for the
injection (floor), voltage errors over the EMF for the observer (bias). A weight below CUT counts as
0, so that the injection can stop.
"""

import numpy as np
from numpy.typing import NDArray

from sensorless.baselines.rule import Parameter, Rule, Values
from sensorless.core.api import SIGNAL_NAMES
from sensorless.machine.motor import Motor
from sensorless.observers.hfi_design import error_slope
from sensorless.policy import NO_SETTINGS, Settings, Signals

CUT = 0.02
RESIDUAL = 0.5
"""Error signal that the value 1 of the residual signals stands for."""

EMF, HFI, SMO = (SIGNAL_NAMES.index(name) for name in ("emf", "hfi_residual", "smo_residual"))


class InnovationFusion:
    """The rule above, without memory. A signal that is not a number gives all injection.

    Parameters
    ----------
    name : str
    floor : float
        Error of the injection's angle that its innovation does not show [rad].
    bias : float
        Voltage error of the observer over the rated no-load EMF [-].
    slope : float
        Error signal of the injection over its angle error [-].
    """

    sensored = False
    settings: Settings = NO_SETTINGS

    def __init__(self, name: str, floor: float, bias: float, slope: float) -> None:
        self.name = name
        self.floor, self.bias, self.slope = floor, bias, slope

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def variances(self, obs: Signals) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Error variances of the two angles [rad^2], each (n,)."""
        x = obs.astype(np.float64)
        r_hfi = (RESIDUAL * x[:, HFI] / self.slope) ** 2 + self.floor**2
        r_smo = (RESIDUAL * x[:, SMO]) ** 2 + (self.bias / np.maximum(x[:, EMF], 1e-6)) ** 2
        return r_hfi, r_smo

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights (n,)."""
        r_hfi, r_smo = self.variances(obs)
        k_s = r_smo / (r_hfi + r_smo)
        k_s[~np.isfinite(k_s)] = 1.0
        k_s[k_s < CUT] = 0.0
        return k_s.astype(np.float32)


def _build(name: str, v: Values, motor: Motor) -> InnovationFusion:
    slope = error_slope(motor.L_d, motor.L_q)
    return InnovationFusion(name, np.deg2rad(v["floor"]), 0.01 * v["bias"], slope)


RULE = Rule(
    "fusion",
    "Kalman fusion: angles weighted by the inverse of their innovation variances",
    _build,
    (
        Parameter(
            "floor", 5.0, "deg", 0.01, 180, "hidden error of the injection", search=(0.5, 30.0)
        ),
        Parameter(
            "bias", 2.0, "%", 0.001, 1000, "voltage error over rated EMF", search=(0.1, 20.0)
        ),
    ),
)
