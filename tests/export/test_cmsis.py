"""The CMSIS-DSP layout gives the core's k_s, at and beyond the edges too."""

import re

import numpy as np
import pytest
from numpy.typing import NDArray

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.export.cmsis import cmsis_files, padded, readme
from sensorless.export.export import Exported
from sensorless.table.ks_table import Axis, KsTable

F = np.float32


def arm_bilinear_interp(data: NDArray[np.float32], x: F, y: F) -> F:
    """As documented: 0 outside, and from the last row and column on."""
    rows, columns = data.shape
    i, j = int(x), int(y)
    if i < 0 or i > columns - 2 or j < 0 or j > rows - 2:
        return F(0.0)
    f00, f01, f10, f11 = data[j, i], data[j, i + 1], data[j + 1, i], data[j + 1, i + 1]
    dx, dy = x - F(i), y - F(j)
    return F(f00 + (f01 - f00) * dx + (f10 - f00) * dy + (f00 - f01 - f10 + f11) * dx * dy)


def index(axis: Axis, signal: F) -> F:
    """As ``ks_cmsis_x`` and ``ks_cmsis_y``."""
    return np.clip((signal - F(axis.lo)) * axis.inv_step, F(0.0), F(axis.n - 1))


def places(axis: Axis) -> NDArray[np.float32]:
    ends = F(axis.lo), F(axis.hi)
    close = [np.nextafter(end, F(side)) for end in ends for side in (-1e9, 1e9)]
    return np.unique(np.array([-1e6, *axis.nodes - F(0.01), *axis.nodes, *close, 1e6], dtype=F))


def test_padded_data_give_the_weight_of_the_core(table: KsTable) -> None:
    row, column = table.axes
    at = np.array([(v, u) for v in places(row) for u in places(column)], dtype=F)
    obs = np.zeros((len(at), SIGNAL_N), dtype=F)
    obs[:, [SIGNAL_NAMES.index(a.signal) for a in table.axes]] = at
    data = padded(table)
    k_s = [arm_bilinear_interp(data, index(column, u), index(row, v)) for v, u in at]
    assert np.abs(np.array(k_s) - table.evaluate(obs)).max() < 1e-6


def test_the_trap_is_real(table: KsTable) -> None:
    ones = np.ones(table.values.shape, dtype=F)
    last_row, last_column = (F(a.n - 1) for a in table.axes)
    assert arm_bilinear_interp(ones, last_column - F(0.5), last_row - F(0.5)) == 1.0
    assert arm_bilinear_interp(ones, last_column, F(0.0)) == 0.0
    assert arm_bilinear_interp(ones, F(0.0), last_row) == 0.0
    both = np.pad(ones, ((0, 1), (0, 1)), mode="edge")
    assert arm_bilinear_interp(both, last_column, last_row) == 1.0


def test_the_files_hold_the_padded_data(exported: Exported, table: KsTable) -> None:
    header = (exported.folder / "cmsis" / "ks_table_cmsis.h").read_text()
    assert re.search(r"KS_CMSIS_ROWS 10\b", header) and re.search(r"KS_CMSIS_COLS 6\b", header)
    body = (exported.folder / "cmsis" / "ks_table_cmsis.c").read_text().partition(" = {")[2]
    read = np.array(re.findall(r"([\d.e+-]+)f\b", body), dtype=F)
    assert read.tobytes() == padded(table).tobytes()
    said = (exported.folder / "README.md").read_text()
    assert "ks_cmsis_x(torque_current), ks_cmsis_y(speed)" in said and "Beware" in said


@pytest.mark.parametrize("n_axes", [1, 3])
def test_other_tables_have_no_such_layout(n_axes: int) -> None:
    names = ("speed", "torque_current", "emf")[:n_axes]
    axes = tuple(Axis(name, 0.0, 1.0, 2) for name in names)
    t = KsTable(axes, np.zeros((2,) * n_axes, dtype=F))
    assert not cmsis_files(t)
    assert f"two axes, and this table has {n_axes}" in readme(t)
