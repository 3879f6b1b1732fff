"""What a schedule may not tell apart at standstill: the two directions of motion.

Signals with a sign count as positive in the direction of motion. At standstill the noise of the
speed decides which direction that is, and under load the torque current, say, jumps from 1 to -1
and back. A schedule that has other values there than here would make k_s hop with it.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from sensorless.table.axis import Axis

SIGNED = ("torque_current", "disagreement", "acceleration", "speed_error", "speed_ref")
"""Signals that change sign with the direction of motion."""


def turned_round(axes: Sequence[Axis]) -> NDArray[np.intp]:
    """Flat index of the node that takes a node's place when the direction of motion changes (N,).

    At the lowest speed of the table, which is in force at standstill, the one with all signed
    signals negated; elsewhere the node itself, and so everywhere in a table without speed, or with
    a signed axis that is not symmetric about 0.
    """
    index = np.arange(int(np.prod([a.n for a in axes]))).reshape([a.n for a in axes])
    names = [a.signal for a in axes]
    signed = tuple(j for j, a in enumerate(axes) if a.signal in SIGNED)
    if "speed" in names and all(axes[j].lo == -axes[j].hi for j in signed):
        lowest = (slice(None),) * names.index("speed") + (0,)
        index[lowest] = np.flip(index, signed)[lowest]
    return index.reshape(-1)


def even_at_standstill(values: NDArray[np.float32], axes: Sequence[Axis]) -> NDArray[np.float32]:
    """Values at the nodes, each averaged with the one that takes its place in the other direction.

    Parameters
    ----------
    values : array of float32
        In the shape of the axes.
    """
    flat = values.reshape(-1)
    return (np.float32(0.5) * (flat + flat[turned_round(axes)])).reshape(values.shape)
