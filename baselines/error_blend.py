"""Weighted error signals in one loop instead of weighted angles (``core/blend.h``)."""

from sensorless.baselines.on_estimator import ramp_on

RULE = ramp_on(
    "error_blend", "errors", "ramp of the speed that weighs error signals in one loop, not angles"
)
