"""What a replayed log shows over time."""

import numpy as np

from sensorless.plots.wave import DASH, Curve, Pane, Wave, merged
from sensorless.replay.replay import Replay
from sensorless.units import RAD_S_TO_RPM

STYLES = {
    "ekf": ("ekf", 1.0),
    "hfi": ("blush", 2.6),
    "blend": ("own", 1.8),
    "smo": ("observer", 1.4),
}
"""Colour and width of each estimator, in the order in which they are drawn."""
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
    for name, style in STYLES.items():
        estimate, dash = r.estimates[name], DASH if name == "smo" else ()
        speeds.append(Curve(r.label(name), style[0], rpm * estimate.omega_e, style[1], dash))
        error = r.error(name)
        shown = np.rad2deg(estimate.theta_e if error is None else error)
        known = np.where(estimate.valid, shown, np.nan)
        angles.append(Curve(r.label(name), style[0], known, style[1], dash))
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
