"""Whether a flux map bears out the pole that its saturation model shows at rest."""

from collections.abc import Iterator

import numpy as np

from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.motor import Motor
from sensorless.observers.start_design import POLE_ERROR, knows_poles, peaks, polarity_pulse

STEPS = np.linspace(1.0, 0.1, 19)
"""Pulses that are tried, over those of the start: the longest of which the map has both peaks."""


def pole_unsure(motor: Motor, i: Floats, psi: Floats) -> Iterator[str]:
    """Why pulses might not tell the pole although the model says so, in words; none if they do.

    A model that fits a map within a percent may still see a saturation of d that is not there.

    Parameters
    ----------
    motor : Motor
        With the saturation model that was fitted to the map.
    i, psi : arrays, shape (n, 2)
        The map's currents [A] and flux linkages [Vs].
    """
    from scipy.interpolate import LinearNDInterpolator

    if not knows_poles(motor):
        return
    pulse, wanted = polarity_pulse(motor)
    of_map = LinearNDInterpolator(psi, i[:, 0])
    rest = flux(motor.saturation, np.zeros((1, 2)))[0]
    tail = "; so pole_at_rest = false: the drive wants its angle at a start (drive_init)"
    for share in STEPS:
        d, q = rest
        plus, minus, none = of_map([[d + share * pulse, q], [d - share * pulse, q], [d, q]])
        if np.isfinite(plus + minus):
            model = wanted / motor.i_rated
            found = float(plus + minus - 2.0 * none) / sum(peaks(motor, share * pulse)) * model
            if not abs(found) >= 2.0 * POLE_ERROR:
                yield (
                    f"by the model, pulses at rest tell the pole with {abs(model):.1%} of rated "
                    f"current, by the map with {abs(found):.1%} (from pulses of {share:.0%}), and "
                    f"{2.0 * POLE_ERROR:.0%} are needed{tail}"
                )
            return
    yield f"the map has no current on both sides of rest along d to tell the pole from{tail}"
