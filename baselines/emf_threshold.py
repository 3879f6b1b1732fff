"""Hard switch at a threshold of the estimated back-EMF, in per cent of the DC-link voltage.

    k_s = 0       |e_hat| >= (threshold + band) u_dc
    k_s = 1       |e_hat| <= max(threshold - band, threshold / 10) u_dc
    k_s = unchanged   in the gap between the two

The MESC firmware compares |u_q - R_s i_q| with 5 % of u_dc, with a gap of 1 V (2 % of 48 V). Here
the observer's EMF replaces that difference, and u_dc is the nominal voltage.
"""

from math import inf

from sensorless.baselines.hysteresis import Hysteresis
from sensorless.baselines.rule import Parameter, Rule, Values
from sensorless.machine.motor import Motor


def emf_threshold(name: str, threshold: float, band: float, motor: Motor) -> Hysteresis:
    """Switch at a threshold +- half a gap, both in per cent of the DC-link voltage."""
    unit = 0.01 * motor.u_dc / (motor.omega_rated * motor.psi_f)
    low = max(threshold - band, 0.1 * threshold)
    return Hysteresis(name, low * unit, (threshold + band) * unit, "emf")


def _build(name: str, v: Values, motor: Motor) -> Hysteresis:
    return emf_threshold(name, v["threshold"], v["band"], motor)


RULE = Rule(
    "emf",
    "hard switch of the estimated back-EMF at THRESHOLD +- BAND % of the DC-link voltage",
    _build,
    (
        Parameter("threshold", 5.0, "%", 0.01, inf, "EMF over DC-link voltage", search=(1.0, 60.0)),
        Parameter("band", 1.0, "%", 0.001, inf, "half the gap", search=(0.1, 20.0)),
    ),
)
