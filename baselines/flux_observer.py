"""A stator-flux observer in place of the sliding-mode one (``core/flux_observer.h``)."""

from sensorless.baselines.on_estimator import ramp_on

RULE = ramp_on(
    "flux_observer", "flux", "ramp of the speed from injection to a flux observer, not to the SMO"
)
