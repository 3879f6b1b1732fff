"""The README of an export, in the order in which an integrator asks."""

import math
from string import Template

from sensorless.core.api import TABLE, Array, ffi
from sensorless.design.words import observer_name
from sensorless.export.cmsis import cmsis_files
from sensorless.export.cmsis import readme as cmsis_readme
from sensorless.export.core_files import FIRMWARE
from sensorless.export.faults import fault_tables
from sensorless.export.gains import gain_readme
from sensorless.export.hook import hook_text
from sensorless.export.start import lost_text, start_call, start_text
from sensorless.machine.motor import Motor
from sensorless.observers.bring_up_design import plan_bring_up
from sensorless.observers.injection_signal import NOISE_AT, SENSOR_NOISE
from sensorless.observers.start_design import knows_poles
from sensorless.table.ks_table import KsTable

TWO = """\
The drive has two estimators of the rotor angle: high-frequency injection and the {observer}. The
schedule gives the weight `k_s` (1: injection leads, 0: the {observer} leads)"""
ONE = """\
The drive has one estimate of the rotor, that of the {observer}, from voltages and high-frequency
injection together. The schedule gives `k_s`, the weight with which injection corrects it (1: fully,
0: voltages alone)"""

COMPENSATED = """\
Compensation is built in: `drive_step` adds up to {u_dt:.3g} V to each leg by the direction of its
current. A driver or timer that also compensates makes it twice, which shows as a current that does
not fall to zero. Keep one: switch the driver's off, or export with `--set dead_time_share=0`, with
`--force` too if that is refused: it is judged on an inverter that nobody compensates."""
LEFT = """\
This export does not compensate it: the driver or the timer has to, once."""
NOT_OURS = "dead time is not judged, because this export leaves it to the driver"


def readme(
    table: KsTable,
    motor: Motor,
    drive: Array,
    check_time: float,
    policy: str,
    observer: str,
    periods: int,
    vectors: tuple[int, int],
    texts: tuple[str, str, str],
) -> str:
    """``README.md``.

    Parameters
    ----------
    drive : record of ``drive_params_t``
    check_time : float
        That the check of the installation takes [s].
    policy, observer : str
        Names of the schedule and of the estimator that leads at high speed.
    periods : int
        PWM periods from one decision of the schedule to the next.
    vectors : tuple of int
        Golden lookups of a table; golden periods of the drive.
    texts : tuple of str
        Verdict, and what is said about the two thresholds and about a shaft that spins.
    """
    plan = plan_bring_up(motor)
    leads = (ONE if observer == "coupled" else TWO).format(
        observer=observer_name(observer).replace("SMO", "sliding-mode observer")
    )
    u_dt = float(drive["control"]["u_dt"])
    judged = plan.u_lost > 0.0 and u_dt > 0.0
    limits = plan.limits if u_dt > 0.0 else (*plan.limits, NOT_OURS)
    tables = fault_tables(bool(table.gains), judged, knows_poles(motor))
    if limits:
        tables["check"] += f"\n\nWith this motor, {'; '.join(limits)}."
    axes = "\n".join(
        f"| {j} | {a.signal} | {a.lo:g} | {a.hi:g} | {a.n} |" for j, a in enumerate(table.axes)
    )
    return Template((FIRMWARE / "export_readme.md").read_text(encoding="utf-8")).substitute(
        policy=policy,
        verdict=texts[0],
        motor=f"{motor.name} ({motor.description})",
        T_s_us=f"{motor.T_s * 1e6:g}",
        n_p=motor.n_p,
        i_trip=f"{motor.i_trip:g}",
        i_over=f"{math.sqrt(float(drive['guard']['i_over_sq'])):.4g}",
        i_short=f"{motor.psi_f / motor.L_d:.4g}",
        dead_time=f"{1e9 * motor.dead_time:.6g}",
        compensation=COMPENSATED.format(u_dt=u_dt) if u_dt > 0.0 else LEFT,
        check_of="delay, signs, phases"
        + (", duty formula and dead time" if judged else " and duty formula"),
        check_ms=f"{1e3 * check_time:.0f}",
        periods=periods,
        leads=leads,
        axes=axes,
        drive_vectors=vectors[1],
        table_bytes=20 * vectors[0],
        state_bytes=state_bytes(table),
        f32_bytes=TABLE.itemsize + 4 * table.values.size,
        q15_bytes=TABLE.itemsize + 2 * table.values.size,
        x_min=f"{table.rule[0]:.3g}",
        x_max=f"{table.rule[1]:.3g}",
        fallback=f"{table.fallback:g}",
        start_call=start_call(motor),
        start_text=start_text(motor),
        spin_text=texts[2],
        lost_text=lost_text(int(drive["lock"]["action"]), motor, observer),
        cmsis=cmsis_readme(table),
        cmsis_sources=" cmsis/*.c" if cmsis_files(table) else "",
        two_threshold=texts[1],
        hook=hook_text(table),
        omega_most=f"{float(drive['guard']['omega']):.4g}",
        noise=f"{SENSOR_NOISE[1] * motor.i_rated / NOISE_AT:.2g}",
        i_most=f"{float(drive['guard']['i_sample']):.4g}",
        **{f"{word}_bits": rows for word, rows in tables.items()},
        **gain_readme(table),
    )


def state_bytes(table: KsTable) -> int:
    """RAM that a drive and its schedule keep from period to period; the same on every target."""
    schedule = "gain_schedule_state_t" if table.gains else "ks_schedule_state_t"
    kept = ["drive_state_t", schedule, *(["drive_params_t"] if table.gains else [])]
    return sum(map(ffi.sizeof, kept))
