"""Whether a log shows the pulses of a motor's check, by when its current steps."""

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import Array
from sensorless.core.bring_up import pulse_times
from sensorless.machine.phases import clarke, with_third

LATE = 4
"""Samples from a command on within which its current has stepped, however wrong the delay."""
LARGE = 16
"""Steps that have to be large: a glitch of a sensor makes fewer."""
CLEAR, HIGH = 5.0, 0.3
"""They are so many times the median step, and so large over the largest of all."""
ASIDE = 0.4
"""Large steps where none belongs, over those where they do, per sample: above it the pulses are
others. On the shipped motors, with every mistake, it is 0 in a log of their own and 0.8 or more in
one of another motor, unless both have their pulses at the same times."""


def shows_others(params: Array, i_a: Array, i_b: Array) -> bool:
    """Whether samples (n,) [A] have pulses, but not where ``bring_up_params_t`` has them.

    Only the pulses along d count, whose times are the motor's own. Where they are too few or too
    weak to tell, the answer is no.
    """
    first, cycle, pulses = pulse_times(params)
    step = np.linalg.norm(np.diff(clarke(with_third(i_a, i_b)), axis=0), axis=1)
    of_push = step[first : first + pulses]
    if len(of_push) < 2 * cycle:
        return False
    large = np.partition(of_push, -LARGE)[-LARGE]
    if not large > max(CLEAR * np.median(of_push), HIGH * np.partition(step, -3)[-3]):
        return False
    seen, gap = of_push > 0.5 * large, _gaps(params, cycle, len(of_push))
    return bool(seen[gap].mean() > ASIDE * seen[~gap].mean())


def _gaps(params: Array, cycle: int, n: int) -> NDArray[np.bool_]:
    """(n,) steps behind a cycle of pulses: nothing is commanded, and the current is gone."""
    at = np.arange(1, n + 1) % cycle
    return np.asarray((at == 0) | (at > cycle - params["n_gap"].item() + LATE))
