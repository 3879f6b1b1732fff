"""C text of an export: numbers for the schedule alone, in a drive with its own observers."""

from sensorless.core.api import Array
from sensorless.export.code import NOTE, c_float, initialiser, schedule_initialiser
from sensorless.export.provenance import motor_hash
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import KsTable

KNOWN = ("speed", "torque_current", "disagreement", "acceleration", "k_s")
"""Signals that ``ks_hook_step`` knows; the core refuses a table over others."""
FULL = 2.0
"""Q15 number 1, over rated speed and rated current."""


def hook_header() -> str:
    """``ks_hook_params.h``."""
    return f"""{NOTE}#ifndef KS_HOOK_PARAMS_H
#define KS_HOOK_PARAMS_H

#include "core/ks_hook.h"

#ifdef __cplusplus
extern "C" {{
#endif

extern const ks_hook_params_t ks_hook_params;

#ifdef __cplusplus
}}
#endif

#endif
"""


def hook_source(motor: Motor, drive: Array, table: KsTable, periods: int) -> str:
    """``ks_hook_params.c``.

    Parameters
    ----------
    drive : record of ``drive_params_t``
    periods : int
        PWM periods from one decision of the schedule to the next.
    """
    signal = initialiser(drive["signal"], "signal_params_t").replace("\n", "\n    ")
    number = f"0x{motor_hash(motor):08X}UL"
    return f"""{NOTE}#include "ks_hook_params.h"

#include "ks_table_data.h"

const ks_hook_params_t ks_hook_params = {{
    .schedule = {schedule_initialiser(table.rule, periods, "    ", number)},
    .signal = {signal},
    .k_s_step = {c_float(drive["k_s_step"])}, /* largest change of k_s per period */
    .omega_full = {c_float(FULL * motor.omega_rated)}, /* {FULL:g} times rated [rad/s] */
    .i_full = {c_float(FULL * motor.i_rated)}, /* {FULL:g} times rated [A] */
    .omega_most = {c_float(drive["guard"]["omega"])}, /* largest plausible speed [rad/s] */
    .i_most = {c_float(drive["guard"]["i_sample"])}, /* largest plausible torque current [A] */
}};
"""


def hook_text(table: KsTable) -> str:
    """What the README says about the hook and this table."""
    others = [axis.signal for axis in table.axes if axis.signal not in KNOWN]
    if others:
        return (
            f"This table also reads {', '.join(others)}, which such a drive does not hand over: "
            "`ks_hook_init` refuses it, and the built-in linear rule of the speed decides."
        )
    return "`make example` builds and runs `example/foreign_drive.c`, which shows all of it."
