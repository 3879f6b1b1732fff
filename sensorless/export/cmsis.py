"""The schedule in the layout of ``arm_bilinear_interp_f32`` of CMSIS-DSP, for tables of two axes.

That function returns 0 not only outside its data but also from the last row and column on, and 0
means that the observer leads alone. So the data repeat the last row and the last column, and the
indices are clipped before the call.
"""

import numpy as np
from numpy.typing import NDArray

from sensorless.export.code import NOTE, c_float, lines
from sensorless.table.axis import Axis
from sensorless.table.ks_table import KsTable

AXES = 2
HEADER = "cmsis/ks_table_cmsis.h"
SOURCE = "cmsis/ks_table_cmsis.c"

README = """`cmsis/` holds the float32 table for `arm_bilinear_interp_f32` of CMSIS-DSP:

    arm_bilinear_interp_instance_f32 s = {KS_CMSIS_ROWS, KS_CMSIS_COLS, ks_cmsis_data};
    float k_s = arm_bilinear_interp_f32(&s, ks_cmsis_x($x), ks_cmsis_y($y));

Beware: that function returns 0 outside its data *and at the last row and column*, which would hand
over to the observer at once. So `ks_cmsis_data` repeats the last row and column, and `ks_cmsis_x`
and `ks_cmsis_y` turn a signal into an index and clip it to the table. The result equals that of the
core except for rounding; `make selftest` compares the two.

Three limits remain. A NaN reads the first node instead of the fallback. The core's CRC does not
cover these data. Older CMSIS releases, whose `pData` is not const and which read at `xIndex - 1`,
cannot be used: they count from 1 and compare X with the number of rows."""

LEFT_OUT = """This export has no `cmsis/`: `arm_bilinear_interp_f32` of CMSIS-DSP takes exactly
two axes, and this table has $n. `ks_table_eval` of the core takes one to four."""


def padded(table: KsTable) -> NDArray[np.float32]:
    """Node values (rows + 1, columns + 1), with the last row and column repeated."""
    return np.pad(table.values, ((0, 1), (0, 1)), mode="edge")


def readme(table: KsTable) -> str:
    """Paragraph about the layout, or about why there is none."""
    if len(table.axes) != AXES:
        return LEFT_OUT.replace("$n", str(len(table.axes)))
    y, x = (axis.signal for axis in table.axes)
    return README.replace("$x", x).replace("$y", y)


def cmsis_files(table: KsTable) -> dict[str, str]:
    """Header and source by name; none if the table does not have two axes."""
    if len(table.axes) != AXES:
        return {}
    return {HEADER: _header(*table.axes), SOURCE: _source(table)}


def _header(row: Axis, column: Axis) -> str:
    return f"""{NOTE}#ifndef KS_TABLE_CMSIS_H
#define KS_TABLE_CMSIS_H

/* numRows and numCols: one more than the table has nodes; the last is repeated. */
#define KS_CMSIS_ROWS {row.n + 1}
#define KS_CMSIS_COLS {column.n + 1}

/* pData of arm_bilinear_interp_instance_f32. */
#ifdef __cplusplus
extern "C" {{
#endif

extern const float ks_cmsis_data[KS_CMSIS_ROWS * KS_CMSIS_COLS];

#ifdef __cplusplus
}}
#endif


/* Index from 0 to last; 0 for NaN. Without it arm_bilinear_interp_f32 returns 0 outside. */
static inline float ks_cmsis_clip(float index, float last) {{
    float low = index > 0.0f ? index : 0.0f;
    return low < last ? low : last;
}}

/* X, the column. */
static inline float ks_cmsis_x(float {column.signal}) {{
    return {_index(column)};
}}

/* Y, the row. */
static inline float ks_cmsis_y(float {row.signal}) {{
    return {_index(row)};
}}

#endif
"""


def _index(axis: Axis) -> str:
    x_0, inv_step, last = (c_float(x) for x in (axis.lo, axis.inv_step, axis.n - 1))
    return f"ks_cmsis_clip(({axis.signal} - ({x_0})) * {inv_step}, {last})"


def _source(table: KsTable) -> str:
    data = padded(table)
    values = [c_float(x) for x in data.reshape(-1)]
    return f"""{NOTE}#include "ks_table_cmsis.h"

/* One row per line; the last row, and the last number of each row, repeat the one before. */
const float ks_cmsis_data[KS_CMSIS_ROWS * KS_CMSIS_COLS] = {{
{lines(values, "    ", data.shape[1])}
}};
"""
