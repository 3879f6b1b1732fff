"""What a replayed log shows over time."""

import numpy as np

from sensorless.core.api import Array
from sensorless.plots.wave import DASH, Curve, Pane, Wave, merged
from sensorless.replay.replay import Replay
from sensorless.units import RAD_S_TO_RPM

STYLES = {
    "hfi": ("blush", 2.6),
    "ekf": ("ekf", 2.0),
    "blend": ("own", 1.8),
    "smo": ("observer", 1.4),
}
"""Colour and width of each estimator."""
NOISY_SPEED, NOISY_ANGLE = "ekf", "hfi"
"""Whose curve lies below the others, which it would hide."""
WINDOW = 0.005
"""Time over which the encoder's angle becomes a speed [s]."""


def replayed(r: Replay, title: str) -> Wave:
    """Speed, angle error (angle, if there is no encoder) and weight over time."""
    t, theta_e, rpm = r.log.t, r.log.theta_e, RAD_S_TO_RPM / r.motor.n_p
    speeds, angles = [], []
    if theta_e is not None:
        window = max(1, round(WINDOW / r.motor.T_s))
        turned = np.unwrap(theta_e)
        true = np.full(len(t), np.nan)
        before = window // 2
        steps = (turned[window:] - turned[:-window]) / (t[window:] - t[:-window])
        true[before : before + len(steps)] = rpm * steps
        speeds.append(Curve("encoder, over 5 ms", "twin", true, 5.0))
    for name in sorted(STYLES, key=lambda name: name != NOISY_SPEED):
        speeds.append(_curve(r, name, rpm * r.estimates[name].omega_e))
    for name in sorted(STYLES, key=lambda name: name != NOISY_ANGLE):
        error = r.error(name)
        shown = np.rad2deg(r.estimates[name].theta_e if error is None else error)
        angles.append(_curve(r, name, np.where(r.estimates[name].valid, shown, np.nan)))
    what = "angle [° el.]" if theta_e is None else "angle error [° el.], truth − estimate"
    weight = f"weight k_s: 1 HFI, 0 {r.observer}"
    return Wave(
        title,
        t,
        (
            Pane("speed", "speed [r/min]", merged(speeds)),
            Pane("angle", what, merged(angles)),
            Pane("weight", weight, (Curve("k_s", "own", r.k_s),), (-0.05, 1.05)),
        ),
    )


def _curve(r: Replay, name: str, values: Array) -> Curve:
    colour, width = STYLES[name]
    return Curve(r.label(name), colour, values, width, DASH if name == "smo" else ())
