"""What an export has more of where its schedule also sets gains: C text, golden vectors, README."""

import numpy as np

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.core.gains import GAIN_NAMES
from sensorless.export.code import c_float, lines, schedule_initialiser
from sensorless.export.vectors import C_TYPE, Words, as_words, hex_words, places
from sensorless.table import gain_image
from sensorless.table.ks_table import KsTable, ValueFormat

INCLUDE = '#include "core/gain_selftest.h"\n'
"""Line of ``ks_table_data.h`` that brings the types."""


def gain_header(table: KsTable) -> str:
    """Declarations for ``ks_table_data.h``; only how many gains there are if there are none."""
    text = f"\n#define KS_TABLE_GAINS {len(table.gains)} /* gains that the schedule sets */\n"
    for form, c_type in C_TYPE.items() if table.gains else ():
        vectors = f"KS_GAIN_VECTORS_{form.upper()}"
        text += f"""
extern const gain_table_t gain_table_{form};
extern const {c_type} gain_values_{form}[];
#define {vectors} {len(places(table))}
extern const gain_vector_t gain_vectors_{form}[{vectors}];
"""
    return text


def gain_vectors(table: KsTable, form: ValueFormat) -> Words:
    """Lookups (n, axes + gains): the signal of each axis, then the value of each grid."""
    at = places(table)
    obs = np.zeros((len(at), SIGNAL_N), dtype=np.float32)
    obs[:, [SIGNAL_NAMES.index(axis.signal) for axis in table.axes]] = at
    axes = table.record(form).reshape(1)
    header = gain_image.record(table.gains, axes, form, 1e-3)
    found = gain_image.lookup(header, axes, gain_image.stored(table.gains, form), obs)
    kept = [GAIN_NAMES.index(grid.gain) for grid in table.gains]
    return np.column_stack([as_words(at), as_words(found[:, kept])])


def gain_source(table: KsTable, form: ValueFormat, motor_hash: int, decision: float) -> str:
    """Text that follows the k_s table in ``ks_table_data.c`` or ``ks_table_q15.c``."""
    if not table.gains:
        return ""
    axes = table.record(form, motor_hash=motor_hash).reshape(1)
    t = gain_image.record(table.gains, axes, form, decision)[0]
    names = [f"GAIN_{grid.gain.upper()}" for grid in table.gains]
    limits = "\n".join(
        f"        {{{', '.join(c_float(x) for x in row)}}}, /* {name} */"
        for name, row in zip(names, t["limit"].tolist(), strict=False)
    )
    stored = gain_image.stored(table.gains, form)
    values = [c_float(x) if form == "f32" else str(x) for x in stored]
    n = len(table.axes)
    lookups = "\n".join(
        f"    {{{{{hex_words(v[:n])}}}, {{{hex_words(v[n:])}}}}},"
        for v in gain_vectors(table, form)
    )
    return f"""
const gain_table_t gain_table_{form} = {{
    .magic = GAINS_MAGIC,
    .format = GAINS_FORMAT,
    .n_gains = {t["n_gains"]},
    .n_nodes = {t["n_nodes"]},
    .gain = {{{", ".join(names)}}},
    /* rise, bend, least, most, pace */
    .limit = {{
{limits}
    }},
    .crc_table = 0x{t["crc_table"]:08X}UL,
    .crc_values = 0x{t["crc_values"]:08X}UL,
    .crc_header = 0x{t["crc_header"]:08X}UL,
}};

/* Values of the gains, one grid after the other, each like the nodes of k_s. */
const {C_TYPE[form]} gain_values_{form}[] = {{
{lines(values, "    ", table.axes[-1].n)}
}};

/* Signals of the axes, values of the grids. */
const gain_vector_t gain_vectors_{form}[KS_GAIN_VECTORS_{form.upper()}] = {{
{lookups}
}};
"""


def gain_params(table: KsTable, periods: int) -> str:
    """Text that follows ``schedule_params`` in ``params.c``."""
    if not table.gains:
        return ""
    return f"""
/* The same with gains. */
const gain_schedule_params_t gain_schedule_params = {{
    .ks = {schedule_initialiser(table.rule, periods, "    ")},
    .table = &GAIN_TABLE_IN_USE,
    .values = GAIN_VALUES_IN_USE,
}};
"""


def gain_readme(table: KsTable) -> dict[str, str]:
    """Substitutions in the README: what a caller keeps, starts and calls."""
    if not table.gains:
        return {
            "schedule_state": "static ks_schedule_state_t schedule;",
            "schedule_init": "ks_schedule_init(&schedule_params, &schedule);       "
            "/* checks the table */",
            "schedule_step": "ks_schedule_step(&schedule_params, &schedule, &drive_params.signal, "
            "&drive.signal)",
            "drive_step": "drive_step(&drive_params, &drive, &in)",
            "schedule_fault": "schedule.fault",
            "schedule_type": "ks_schedule_params_t left_schedule_params",
            "schedule_header": "ks_schedule.h",
            "gains": "",
        }
    rows = "\n".join(
        f"| {g.gain} | {g.range.low:g} | {g.range.high:g} | {1e3 * g.range.settle:g} |"
        for g in table.gains
    )
    return {
        "schedule_state": "static gain_schedule_state_t schedule;\n"
        "static drive_params_t live; /* copy of drive_params with the gains in force */",
        "schedule_init": "gain_schedule_init(&gain_schedule_params, &schedule, &drive_params, "
        "&live); /* checks */",
        "schedule_step": "gain_schedule_step(&gain_schedule_params, &schedule, &drive_params,\n"
        "                                    &live, &drive.signal)",
        "drive_step": "drive_step(&live, &drive, &in)",
        "schedule_fault": "schedule.ks.fault",
        "schedule_type": "gain_schedule_params_t left_gain_schedule_params",
        "schedule_header": "gain_schedule.h",
        "gains": f"""
It also sets gains of the drive (`core/gains.h`), one in each of the periods after a decision on
`k_s`. Factors on the number in `params.h`:

| gain | least | most | time constant [ms] |
| --- | --- | --- | --- |
{rows}

A damaged table of gains (`KS_FAULT_GAINS`) leaves them all at 1; `k_s` goes on by its own table.
A damaged word of `live` is restored within as many decisions as it has words (`KS_FAULT_PARAMS`).
Until then it may keep the drive without voltage (`FAULT_STATE` in every period) or hide an
over-current from the core: leave that to the trip.
""",
    }
