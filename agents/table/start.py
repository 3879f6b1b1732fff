"""The table that training starts from: a schedule copied onto the grid of the run."""

from collections.abc import Iterator

import numpy as np

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import Axis, KsTable

MARGIN = 0.25
"""How far nodes of k_s may lie outside [0, 1] in training, unless something else is asked for."""
AXES, PLACED = "speed:0:1:16,disagreement:-1.5:1.5:5", "speed:16,disagreement:-1.5:1.5:5"
"""Axes unless something else is asked for: the ends of the paper's band are nodes; and those where
a linear start has other ends."""
TO_RATED = 1.0
"""Speed that a placed axis must reach, over rated speed."""


def start_table(axes: str, start: str, source: KsTable, motor: Motor, slew_per_s: float) -> KsTable:
    """Copy a schedule onto a grid.

    A linear ramp of the speed is copied exactly if the ends of its band are nodes, which is
    required; ``AXES`` give way to ``PLACED`` for that. A table is copied exactly if its own axes
    are taken. Any other schedule is sampled at the nodes.

    Parameters
    ----------
    axes : str
        ``SIGNAL:LOW:HIGH:NODES,...``; ``speed:NODES`` places the nodes so that the ends of a linear
        start are among them; ``start`` takes the axes of the start.
    start : str
        Name of the schedule, for messages.
    source : KsTable
        The schedule.
    motor : Motor
        Turns speeds of nodes into r/min, for messages.
    slew_per_s : float
        Largest change of k_s in the drive [1/s].

    Raises
    ------
    UserError
        The axes cannot be read, lack a signal that the start looks at, or have no node at an end
        of a linear start.
    """
    if axes == "start":
        return KsTable(source.axes, source.values, slew_per_s=slew_per_s)
    ramp = source.axes[0] if source.values.tolist() == [1.0, 0.0] else None
    shape = grid(axes, ramp if ramp is not None and ramp.signal == "speed" else None)
    known = [axis.signal for axis in shape]
    for axis in source.axes:
        if axis.signal not in known:
            raise UserError(
                f"axes: {axes!r} lack {axis.signal}, which start {start!r} looks at; "
                "add that axis, or take all of the start's with axes=start"
            )
        if axis is ramp:
            speeds = shape[known.index(axis.signal)]
            if axes == AXES and list(_beside(speeds, ramp)):
                return start_table(PLACED, start, source, motor, slew_per_s)
            _check_corners(speeds, ramp, start, motor)
    obs = np.zeros((*(axis.n for axis in shape), SIGNAL_N), dtype=np.float32)
    for a, nodes in enumerate(np.meshgrid(*(axis.nodes for axis in shape), indexing="ij")):
        obs[..., SIGNAL_NAMES.index(shape[a].signal)] = nodes
    k_s = source.evaluate(obs.reshape(-1, SIGNAL_N)).reshape(obs.shape[:-1])
    # A node may miss the end of a ramp by a rounding error: 0 must stay 0, for no injection.
    return KsTable(shape, np.round(k_s, 5), slew_per_s=slew_per_s)


def grid(text: str, ramp: Axis | None = None) -> tuple[Axis, ...]:
    """Read axes from a text as in ``start_table``.

    Parameters
    ----------
    text : str
    ramp : Axis, optional
        Linear rule whose ends ``speed:NODES`` puts on nodes.

    Raises
    ------
    UserError
        The text cannot be read.
    """
    try:
        words = [word.split(":") for word in text.split(",")]
        return tuple(
            _placed(int(word[1]), ramp)
            if len(word) == 2 and word[0] == "speed" and ramp is not None
            else _axis(*word)
            for word in words
        )
    except (ValueError, TypeError) as error:
        if isinstance(error, UserError):
            raise
        raise UserError(
            f"axes: {text!r} cannot be read; write SIGNAL:LOW:HIGH:NODES,..., or start, or with a "
            "linear start speed:NODES"
        ) from None


def _axis(name: str, low: str, high: str, n: str) -> Axis:
    return Axis(name, float(low), float(high), int(n))


def _placed(n: int, ramp: Axis) -> Axis:
    """Finest speed axis of n nodes from 0 or above to rated speed with both ends on nodes."""
    for cells in range(max(n - 1, 1), 0, -1):
        step = (ramp.hi - ramp.lo) / cells
        first = max(ramp.lo - np.floor(ramp.lo / step + 1e-6) * step, 0.0)
        last = first + (n - 1) * step
        if last >= max(TO_RATED, ramp.hi) - 1e-6 * step:
            return Axis("speed", float(first), float(last), n)
    return Axis("speed", ramp.lo, ramp.lo + (n - 1) * (ramp.hi - ramp.lo), n)


def _beside(axis: Axis, ramp: Axis) -> Iterator[float]:
    """Ends of the ramp that are no nodes of the axis, over rated speed."""
    nodes = np.linspace(axis.lo, axis.hi, axis.n)
    for end in (ramp.lo, ramp.hi):
        if np.min(np.abs(nodes - end)) > 1e-3 * (nodes[1] - nodes[0]):
            yield end


def _check_corners(axis: Axis, ramp: Axis, start: str, motor: Motor) -> None:
    nodes = np.linspace(axis.lo, axis.hi, axis.n)
    for end in _beside(axis, ramp):
        near = ", ".join(f"{x * motor.n_rated_rpm:g}" for x in nodes)
        raise UserError(
            f"start: {start!r}: {end * motor.n_rated_rpm:g} r/min is not a node of the "
            f"speed axis; start at two of its nodes ({near}), or give axes speed:{axis.n},..."
        )
