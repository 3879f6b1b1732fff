"""C text of an export: the schedule's tables and all golden vectors. No logic is generated."""

from sensorless.export.code import NOTE, c_float, lines
from sensorless.export.gains import INCLUDE, gain_header, gain_source
from sensorless.export.vectors import C_TYPE, DriveVectors, Words, hex_words
from sensorless.table.ks_table import KsTable, ValueFormat


def _in_use(gains: bool) -> str:
    """Names of what ``params.c`` takes; one flag of the compiler chooses, so no file is edited."""

    def names(form: ValueFormat) -> str:
        text = (
            f"#define KS_TABLE_IN_USE ks_table_{form}\n#define KS_VALUES_IN_USE ks_values_{form}\n"
        )
        more = f"#define GAIN_TABLE_IN_USE gain_table_{form}\n"
        more += f"#define GAIN_VALUES_IN_USE gain_values_{form}\n"
        return text + (more if gains else "")

    return f"""
/* With -DKS_USE_Q15, and ks_table_q15.c instead of ks_table_data.c, the schedule in 16 bits. */
#ifdef KS_USE_Q15
{names("q15")}#else
{names("f32")}#endif
"""


def table_header(table: KsTable, vectors: int, cmsis: bool) -> str:
    """``ks_table_data.h`` with ``vectors`` golden lookups per table; whether there is a cmsis/."""
    tables = "".join(
        f"""
extern const ks_table_t ks_table_{form};
extern const {c_type} ks_values_{form}[];
#define KS_VECTORS_{form.upper()} {vectors}
extern const ks_vector_t ks_vectors_{form}[KS_VECTORS_{form.upper()}];
"""
        for form, c_type in C_TYPE.items()
    )
    return f"""{NOTE}#ifndef KS_TABLE_DATA_H
#define KS_TABLE_DATA_H

#include "core/ks_selftest.h"
{INCLUDE if table.gains else ""}
#define KS_TABLE_CMSIS {int(cmsis)} /* 1: cmsis/ holds the table, too */

#ifdef __cplusplus
extern "C" {{
#endif
{tables}{gain_header(table)}{_in_use(bool(table.gains))}
#ifdef __cplusplus
}}
#endif

#endif
"""


def table_source(
    table: KsTable, form: ValueFormat, motor_hash: int, vectors: Words, decision: float
) -> str:
    """``ks_table_data.c`` or ``ks_table_q15.c``: header, node values, golden lookups."""
    t = table.record(form, motor_hash=motor_hash)
    names = [f"SIGNAL_{axis.signal.upper()}" for axis in table.axes]
    axes = "\n".join(
        f"        {{{name}, {row['n']}, {c_float(row['x0'])}, {c_float(row['inv_step'])},"
        f" {c_float(row['top'])}}}, /* {axis.lo:g} to {axis.hi:g} */"
        for name, axis, row in zip(names, table.axes, t["axis"], strict=False)
    )
    values = [c_float(x) if form == "f32" else str(x) for x in table.stored(form)]
    lookups = "\n".join(f"    {{{{{hex_words(v[:-1])}}}, {hex_words(v[-1:])}}}," for v in vectors)
    return f"""{NOTE}#include "ks_table_data.h"

const ks_table_t ks_table_{form} = {{
    .magic = KS_TABLE_MAGIC,
    .format = KS_TABLE_FORMAT,
    .value_format = KS_VALUES_{form.upper()},
    .n_axes = {t["n_axes"]},
    .n_nodes = {t["n_nodes"]},
    .kind = 0x{t["kind"]:X}UL,
    .axis = {{
{axes}
    }},
    .slew_per_s = {c_float(t["slew_per_s"])},
    .fallback = {c_float(t["fallback"])},
    .policy_hash = 0x{t["policy_hash"]:08X}UL,
    .motor_hash = 0x{t["motor_hash"]:08X}UL,
    .crc_values = 0x{t["crc_values"]:08X}UL,
    .crc_header = 0x{t["crc_header"]:08X}UL,
}};

/* k_s at the nodes; the last axis varies fastest, one row of it per line. */
const {C_TYPE[form]} ks_values_{form}[] = {{
{lines(values, "    ", table.axes[-1].n)}
}};

/* Signals of the axes, weight. */
const ks_vector_t ks_vectors_{form}[KS_VECTORS_{form.upper()}] = {{
{lookups}
}};
{gain_source(table, form, motor_hash, decision)}"""


def drive_vectors_header(vectors: DriveVectors) -> str:
    """``test/drive_vectors.h``."""
    rows = "\n".join(f"    {{{hex_words(v)}}}," for v in vectors.words)
    start = ", ".join(c_float(x) for x in vectors.start)
    find = ", ".join(f"{j}u" for j in vectors.find)
    return f"""{NOTE}#include "../core/ks_selftest.h"

#define DRIVE_VECTORS {len(vectors.words)}

static const drive_start_t drive_start = {{{start}, {{{find}}}}};

/* i_a, i_b, u_dc, omega_ref, k_s_ref; u_a, u_b, theta, omega. */
static const drive_vector_t drive_vectors[DRIVE_VECTORS] = {{
{rows}
}};
"""
