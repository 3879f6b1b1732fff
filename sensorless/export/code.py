"""C text of an export: the numbers of the drive and of the schedule. No logic is generated."""

import math
from collections.abc import Iterator, Sequence
from typing import Any, SupportsFloat

import numpy as np

from sensorless.core.api import Array, ffi
from sensorless.errors import UserError
from sensorless.export.core_files import field_docs
from sensorless.export.provenance import motor_hash
from sensorless.machine.motor import Motor

NOTE = "/* Numbers written by `sensorless export`. Do not edit: export again. */\n"


def c_float(x: SupportsFloat, name: str = "number") -> str:
    """Float literal that gives back the same float32.

    Raises
    ------
    UserError
        ``x`` is not finite.
    """
    if not np.isfinite(float(x)):
        raise UserError(f"{name}: {x!s}; C code needs a finite number")
    mantissa, e, exponent = f"{np.float32(float(x)):.9g}".partition("e")
    return mantissa + ("" if "." in mantissa else ".0") + e + exponent + "f"


def lines(items: Sequence[str], indent: str, per_line: int) -> str:
    """Comma-separated items, ``per_line`` on a line."""
    rows = (items[j : j + per_line] for j in range(0, len(items), per_line))
    return "\n".join(indent + ", ".join(row) + "," for row in rows)


def initialiser(record: Array, struct: str) -> str:
    """Braced, designated initialiser of a C struct, one documented number per line."""
    fields = _fields(record, ffi.typeof(struct), field_docs(), "    ", "")
    return "{\n" + "\n".join(fields) + "\n}"


def _fields(
    record: Array, ctype: Any, docs: dict[tuple[str, str], str], indent: str, path: str
) -> Iterator[str]:
    for name, field in ctype.fields:
        value, doc = record[name], docs.get((ctype.cname, name))
        comment = f" /* {doc} */" if doc else ""
        if field.type.kind == "primitive":
            yield f"{indent}.{name} = {_number(value, path + name)},{comment}"
            continue
        yield f"{indent}.{name} = {{{comment}"
        if field.type.kind == "struct":
            yield from _fields(value, field.type, docs, indent + "    ", f"{path}{name}.")
        else:
            yield lines([_number(x, path + name) for x in value], indent + "    ", 6)
        yield f"{indent}}},"


def _number(x: Any, name: str) -> str:
    whole = np.asarray(x).dtype.kind in "iu"
    return str(int(x)) if whole else c_float(x, name)


def params_header(motor: Motor, start: str, gains: bool = False) -> str:
    """``params.h``.

    Parameters
    ----------
    motor : Motor
    start : str
        Line that says whether the drive finds its rotor.
    gains : bool
        Whether the schedule also sets gains.
    """
    more = "\nextern const gain_schedule_params_t gain_schedule_params;\n" if gains else ""
    return f"""{NOTE}#ifndef PARAMS_H
#define PARAMS_H

#include "core/bring_up.h"
#include "core/drive.h"
#include "core/ks_schedule.h"
#include "ks_table_data.h"

#define MOTOR_HASH 0x{motor_hash(motor):08X}UL /* first 32 bits of the motor's SHA-256 */
#define MOTOR_POLE_PAIRS {motor.n_p} /* electrical turns in a turn of the shaft */
#define MOTOR_I_TRIP {c_float(motor.i_trip)} /* over-current: switch the inverter off [A], peak */
#define MOTOR_ADC_RANGE {c_float(motor.adc_range)} /* largest current that is measured [A] */
#define MOTOR_U_DC {c_float(motor.u_dc)} /* rated DC link [V] */
#define MOTOR_DEAD_TIME_NS {_nanoseconds(motor.dead_time)}u /* of a leg [ns], at least */
#define MOTOR_T_S {c_float(motor.T_s)} /* PWM period [s] */
#define MOTOR_T_S_NS {_nanoseconds(motor.T_s)}u /* the same in whole steps [ns], at least */
{start}

#ifdef __cplusplus
extern "C" {{
#endif

extern const drive_params_t drive_params;

extern const ks_schedule_params_t schedule_params;

extern const bring_up_params_t bring_up_params;
{more}
#ifdef __cplusplus
}}
#endif

#endif
"""


def _nanoseconds(time: float) -> int:
    """Whole ns, so that the preprocessor can compute with them; rounded up."""
    return math.ceil(round(1e9 * time, 3))


def schedule_initialiser(
    rule: tuple[float, float], periods: int, indent: str = "", motor: str = "MOTOR_HASH"
) -> str:
    """Braced initialiser of ``ks_schedule_params_t``, where the table's names are known.

    Parameters
    ----------
    rule, periods
        As in ``params_source``.
    indent : str
        White space before its last line.
    motor : str
        First 32 bits of the motor's SHA-256, in C.
    """
    x_min, x_max = (c_float(x) for x in rule)
    fields = (
        ".table = &KS_TABLE_IN_USE,",
        ".values = KS_VALUES_IN_USE,",
        f".motor_hash = {motor},",
        f".rule = {{.x_min = {x_min}, .x_max = {x_max}}},",
        f".periods = {periods}, /* PWM periods from one decision to the next */",
    )
    return "{\n" + "".join(f"{indent}    {field}\n" for field in fields) + f"{indent}}}"


def params_source(
    drive: Array, check: Array, rule: tuple[float, float], periods: int, more: str = ""
) -> str:
    """``params.c``.

    Parameters
    ----------
    drive : record of ``drive_params_t``
    check : record of ``bring_up_params_t``
    rule : tuple of float
        Band of the built-in linear rule, speed over rated.
    periods : int
        PWM periods from one decision of the schedule to the next.
    more : str
        Text that follows the schedule.
    """
    return f"""{NOTE}#include "params.h"

const drive_params_t drive_params = {initialiser(drive, "drive_params_t")};

const ks_schedule_params_t schedule_params = {schedule_initialiser(rule, periods)};

/* The check of the installation, before the first drive_step. */
const bring_up_params_t bring_up_params = {initialiser(check, "bring_up_params_t")};
{more}"""
