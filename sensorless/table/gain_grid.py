"""One gain of the drive over the axes of a k_s table."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.core.gains import DEFAULT, GAIN_NAMES, Gain
from sensorless.errors import UserError
from sensorless.table.axis import MAX_NODES, decimal, float32_in

FIELDS = ("gain", "low", "high", "settle_s", "values")


@dataclass(frozen=True, eq=False)
class GainGrid:
    """Values of a gain at the nodes of a table, multilinear between them, clipped outside."""

    gain: str
    """Name in ``GAIN_NAMES``."""
    values: NDArray[np.float32]
    """-1 to 1 at the nodes, in the shape of the table's; 0 is the static gain; read only."""
    low: float | None = None
    """Factor on the static gain at -1, see ``Gain``; None: that of ``gains.DEFAULT``."""
    high: float | None = None
    """Factor at 1; None: that of ``gains.DEFAULT``."""
    settle_s: float | None = None
    """Time constant of the value [s]; None: that of ``gains.DEFAULT``."""

    def __post_init__(self) -> None:
        """Check and round to float32.

        Raises
        ------
        UserError
            A field or a node is out of its range.
        """
        if self.gain not in GAIN_NAMES:
            known = ", ".join(GAIN_NAMES)
            raise UserError(f"table: gains: {self.gain!r} is not a gain; choose from {known}")
        default = DEFAULT[self.gain]
        for name, x, (least, most) in (
            ("low", default.low, (1e-3, 1.0)),
            ("high", default.high, (1.0, 1e3)),
            ("settle_s", default.settle, (1e-6, 1e3)),
        ):
            given = getattr(self, name)
            value = float32_in(f"{self.gain}: {name}", x if given is None else given, least, most)
            object.__setattr__(self, name, value)
        limits = self.range.limits(1e-3)
        if not self.range.rises:
            raise UserError(
                f"table: {self.gain}: low, high: {self.low:g}, {self.high:g}; give factors between "
                "which a parabola through 1 only rises"
            )
        object.__setattr__(self, "values", self._checked(limits["least"], limits["most"]))

    def _checked(self, least: float, most: float) -> NDArray[np.float32]:
        try:
            with np.errstate(over="ignore"):
                nodes = np.array(self.values, dtype=np.float32) + np.float32(0.0)
        except (TypeError, ValueError, OverflowError) as error:
            raise UserError(f"table: {self.gain}: {error}; give numbers from -1 to 1") from None
        bad = np.argwhere(~((nodes >= least) & (nodes <= most)))
        if len(bad):
            index = tuple(int(j) for j in bad[0])
            where = ", ".join(map(str, index))
            raise UserError(
                f"table: {self.gain} [{where}]: {nodes[index]:g}; give {least:g} to {most:g}"
            )
        nodes.setflags(write=False)
        return nodes

    @property
    def range(self) -> Gain:
        """Range as the drive has it."""
        assert self.low is not None and self.high is not None and self.settle_s is not None
        return Gain(self.low, self.high, self.settle_s)

    def fields(self) -> dict[str, Any]:
        """Return all numbers as JSON types, in the fewest digits that restore every float32."""
        limits = self.range
        return {
            "gain": self.gain,
            "low": decimal(limits.low),
            "high": decimal(limits.high),
            "settle_s": decimal(limits.settle),
            "values": np.vectorize(decimal)(self.values).tolist(),
        }


def checked_grids(gains: Any, shape: tuple[int, ...]) -> tuple[GainGrid, ...]:
    """Return the grids of a table in the order of ``GAIN_NAMES``.

    Raises
    ------
    UserError
        Two are of the same gain, one has another shape than the table, or there are too many nodes.
    """
    grids = tuple(sorted(gains, key=lambda g: GAIN_NAMES.index(g.gain)))
    names = [g.gain for g in grids]
    if len(set(names)) < len(names):
        raise UserError(f"table: gains: {', '.join(names)}; give each gain once")
    for g in grids:
        if g.values.shape != shape:
            raise UserError(f"table: {g.gain}: shape {g.values.shape}; give {shape}, as for k_s")
    if len(grids) * int(np.prod(shape)) > MAX_NODES:
        raise UserError(
            f"table: gains: {len(grids)} grids of {int(np.prod(shape))} nodes; give at most "
            f"{MAX_NODES} nodes together"
        )
    return grids
