"""The schedule table: k_s over up to four signals, for training, files, runs and export.

Lookup, check and checksum run the code of ``core/drive/ks_table.c``; there is no second version.
"""

import hashlib
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES, TABLE, Array, lib
from sensorless.core.gains import Gain, Values
from sensorless.errors import UserError, shown
from sensorless.files import read_bytes, reason, write_atomic
from sensorless.table import gain_image
from sensorless.table.axis import MAX_NODES, Axis, decimal, float32_in
from sensorless.table.gain_grid import GainGrid, checked_grids
from sensorless.table.image import bound, check, flat_values, seal
from sensorless.table.json_form import check_crc, content, from_text, to_text

__all__ = ["Axis", "GainGrid", "KsTable", "ValueFormat"]

ValueFormat = Literal["f32", "q15"]
T = TypeVar("T")

MAX_AXES: int = lib.KS_TABLE_AXES


@dataclass(frozen=True, eq=False)
class KsTable:
    """Weight k_s at the nodes of a grid, multilinear between them, clipped outside.

    Gains of the drive may follow on the same grid.
    """

    axes: tuple[Axis, ...]
    values: NDArray[np.float32]
    """k_s at the nodes, 0 to 1, of shape (n of axis 0, n of axis 1, ...); read only."""
    slew_per_s: float = 50.0
    """Largest change of k_s [1/s]; the drive applies it every PWM period."""
    fallback: float = 1.0
    """k_s where a signal is not finite."""
    rule: tuple[float, float] = (0.2, 0.8 / 3.0)
    """Speeds, over rated, between which the rule that replaces a damaged table falls to 0."""
    provenance: Mapping[str, Any] = field(default_factory=dict)
    """Where the table comes from (JSON types); ``motor_digest`` names its machine."""
    gains: tuple[GainGrid, ...] = ()
    """Gains that the schedule sets besides k_s, on the same grid."""

    def __post_init__(self) -> None:
        """Check every field and every node, and round to float32.

        Raises
        ------
        UserError
            A field or a node is out of its range.
        """
        axes = _all_of(Axis, "axes", self.axes)
        names = [axis.signal for axis in axes]
        if not 1 <= len(names) <= MAX_AXES or len(set(names)) < len(names):
            raise UserError(f"table: axes: {', '.join(names)}; give 1 to {MAX_AXES} different ones")
        if not isinstance(self.rule, (tuple, list)) or len(self.rule) != 2:
            raise UserError(f"table: rule: {self.rule!r}; give two speeds, low < high")
        if not isinstance(self.provenance, Mapping):
            raise UserError(f"table: provenance: {self.provenance!r}; give facts by name")
        low, high = (float32_in("rule", x, 0.0, 1e6) for x in self.rule)
        if not low < high:
            raise UserError(f"table: rule: {low:g}, {high:g}; give low < high")
        for name, value in {
            "axes": axes,
            "values": _checked_nodes(self.values, tuple(axis.n for axis in axes)),
            "slew_per_s": float32_in("slew_per_s", self.slew_per_s, 1e-3, 1e6),
            "fallback": float32_in("fallback", self.fallback, 0.0, 1.0),
            "rule": (low, high),
            "gains": checked_grids(
                _all_of(GainGrid, "gains", self.gains), tuple(axis.n for axis in axes)
            ),
        }.items():
            object.__setattr__(self, name, value)

    def evaluate(self, obs: NDArray[np.float32]) -> NDArray[np.float32]:
        """Return k_s (n,) at signals (n, SIGNAL_N), looked up by the firmware's code."""
        return self._lookup(_rows(obs))

    def evaluate_gains(self, obs: NDArray[np.float32]) -> Values:
        """Return values of the gains (n, GAIN_N) at signals (n, SIGNAL_N).

        Raises
        ------
        UserError
            The table sets no gains.
        """
        if not self.gains:
            raise UserError("table: gains: none; evaluate_gains asks a table that sets some")
        header, values = self._gain_image
        return gain_image.lookup(header, self._image[0], values, _rows(obs))

    @property
    def ranges(self) -> dict[str, Gain]:
        """Range of each gain that the table sets, by name."""
        return {grid.gain: grid.range for grid in self.gains}

    def check(self) -> int:
        """Return the result of the firmware's own check: 0, or a key of ``image.PROBLEMS``."""
        found = check(*self._image)
        if found or not self.gains:
            return found
        header, values = self._gain_image
        return gain_image.check(header, self._image[0], values)

    @cached_property
    def _gain_image(self) -> tuple[Array, Array]:
        return (
            gain_image.record(self.gains, self._image[0], "f32", 1e-3),  # a lookup needs no time
            gain_image.stored(self.gains, "f32"),
        )

    @cached_property
    def _lookup(self) -> Callable[[NDArray[np.float32]], NDArray[np.float32]]:
        return bound(*self._image)

    def __getstate__(self) -> dict[str, Any]:
        """Return what a copy in another process needs: no pointers."""
        return {name: x for name, x in vars(self).items() if not name.startswith("_")}

    @cached_property
    def _image(self) -> tuple[Array, Array]:
        return self.record().reshape(1), self.stored()

    def stored(self, form: ValueFormat = "f32") -> Array:
        """Return the node values as the firmware stores them: flat, float32 or int16 (Q15)."""
        return flat_values(self.values, form)

    def record(self, form: ValueFormat = "f32", *, motor_hash: int = 0) -> Array:
        """Header ``ks_table_t`` of the table with its checksums, shape ().

        Parameters
        ----------
        form : {"f32", "q15"}
            Kind of the values, see ``stored``.
        motor_hash : int
            32 bits that name the machine; 0 for none.

        Raises
        ------
        UserError
            ``form`` is neither.
        """
        stored = self.stored(form)
        header = np.zeros(1, dtype=TABLE)
        header["magic"], header["format"] = lib.KS_TABLE_MAGIC, lib.KS_TABLE_FORMAT
        header["value_format"] = lib.KS_VALUES_F32 if form == "f32" else lib.KS_VALUES_Q15
        header["n_axes"], header["n_nodes"] = len(self.axes), self.values.size
        header["kind"] = len(self.axes) | (lib.KS_KIND_Q15 if form == "q15" else 0)
        for row, axis in zip(header["axis"][0], self.axes, strict=False):
            row["signal"], row["n"] = SIGNAL_NAMES.index(axis.signal), axis.n
            row["x0"], row["inv_step"], row["top"] = axis.lo, axis.inv_step, axis.n - 1
        header["slew_per_s"], header["fallback"] = self.slew_per_s, self.fallback
        header["policy_hash"] = int(self.digest[:8], 16)
        header["motor_hash"] = motor_hash
        seal(header, stored)
        return header.reshape(())

    def fields(self) -> dict[str, Any]:
        """Return all numbers as JSON types, in the fewest digits that restore every float32."""
        gains = {"gains": [grid.fields() for grid in self.gains]} if self.gains else {}
        return {
            "axes": [
                {"signal": a.signal, "lo": decimal(a.lo), "hi": decimal(a.hi), "n": a.n}
                for a in self.axes
            ],
            "slew_per_s": decimal(self.slew_per_s),
            "fallback": decimal(self.fallback),
            "rule": [decimal(x) for x in self.rule],
            "values": np.vectorize(decimal)(self.values).tolist(),
            **gains,
        }

    @cached_property
    def digest(self) -> str:
        """SHA-256 over all numbers of the table, hexadecimal; provenance does not count."""
        return hashlib.sha256(content(self.fields())).hexdigest()

    def to_json(self, provenance: Mapping[str, Any] | None = None) -> str:
        """Return the text that ``save`` writes."""
        return to_text(self.fields(), self.provenance if provenance is None else provenance)

    def save(self, path: str | Path, provenance: Mapping[str, Any] | None = None) -> None:
        """Write the table as JSON, whole or not at all.

        Parameters
        ----------
        path : str or Path
        provenance : mapping, optional
            Instead of the table's own.
        """
        write_atomic(path, self.to_json(provenance))

    @classmethod
    def load(cls, path: str | Path) -> "KsTable":
        """Read a table that ``save`` wrote.

        Raises
        ------
        UserError
            The file cannot be read, or is not a table.
        """
        try:
            text = read_bytes(Path(path)).decode("utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise UserError(f"{path}: {reason(error)}; give a table in JSON") from None
        return cls.from_json(text, str(path))

    @classmethod
    def from_json(cls, text: str, where: str) -> "KsTable":
        """Read what ``to_json`` returned; ``where`` names it in messages.

        Raises
        ------
        UserError
            As ``load``.
        """
        fields, provenance, crc = from_text(text, where)
        try:
            table = cls(
                axes=tuple(Axis(**axis) for axis in fields.pop("axes")),
                gains=tuple(GainGrid(**grid) for grid in fields.pop("gains", ())),
                **fields,
                provenance=provenance,
            )
        except UserError as error:
            raise UserError(f"{where}: {error}") from None
        check_crc(table.fields(), crc, where)
        return table


def _all_of(kind: type[T], name: str, given: Any) -> tuple[T, ...]:
    """The objects of one field, each of the kind it takes."""
    if not isinstance(given, (tuple, list)) or not all(isinstance(x, kind) for x in given):
        raise UserError(f"table: {name}: {shown(given)}; give a tuple of {kind.__name__}")
    return tuple(given)


def _rows(obs: NDArray[np.float32]) -> NDArray[np.float32]:
    rows = np.ascontiguousarray(obs, dtype=np.float32)
    if rows.ndim != 2 or rows.shape[1] != SIGNAL_N:
        raise ValueError(f"obs: shape {rows.shape}; give (n, {SIGNAL_N})")
    return rows


def _checked_nodes(values: Any, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Copy of the node values as a read-only float32 array, minus zero turned to zero."""
    if math.prod(shape) > MAX_NODES:
        raise UserError(f"table: {math.prod(shape)} nodes; give at most {MAX_NODES}")
    try:
        with np.errstate(over="ignore"):
            nodes = np.array(values, dtype=np.float32) + np.float32(0.0)
    except (TypeError, ValueError, OverflowError) as error:
        raise UserError(f"table: values: {error}; give numbers from 0 to 1") from None
    if nodes.shape != shape:
        raise UserError(f"table: values: shape {nodes.shape}; give {shape}, that of the axes")
    bad = np.argwhere(~((nodes >= 0.0) & (nodes <= 1.0)))
    if len(bad):
        index = tuple(int(j) for j in bad[0])
        where = ", ".join(map(str, index))
        raise UserError(f"table: node [{where}]: {nodes[index]:g}; give 0 to 1")
    nodes.setflags(write=False)
    return nodes
