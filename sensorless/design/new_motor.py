"""The motor file of a datasheet: numbers that it gives, and those chosen or assumed."""

from dataclasses import replace
from typing import Any

from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.machine.datasheet import Datasheet, Number, check_number, machine_numbers
from sensorless.machine.inverter import LOW_VOLTAGE
from sensorless.machine.motor import Motor
from sensorless.machine.motor_file import tables
from sensorless.machine.saliency import require_saliency
from sensorless.machine.sane import require_sane
from sensorless.observers.injection_signal import suggested_injection
from sensorless.units import RPM_TO_RAD_S

OVERLOAD, TRIP = 1.5, 3.0
"""Current limit of the control, and trip, over rated current; see also ``ADC_ROOM``."""
ADC_ROOM = 0.9
"""Most current limit over the converter's range: leaves room for injection and ripple."""
ROUNDS = 4
"""Rounds of voltage and bandwidth; each changes by the sixth root of what the other did."""
START_TIME = 0.2
"""J omega / tau at rated values, assumed where the inertia is unknown [s]."""


def new_motor(
    name: str,
    sheet: Datasheet,
    *,
    u_dc: float,
    pwm_hz: float,
    adc_range: float | None = None,
    adc_bits: int = 12,
    dead_time: float | None = None,
    u_inj: float | None = None,
    design: DriveDesign,
) -> dict[str, Any]:
    """Tables of a motor file, see ``motor_file.tables``.

    Parameters
    ----------
    name : str
    sheet : Datasheet
    u_dc, pwm_hz, adc_range, adc_bits, dead_time, u_inj : float
        The inverter: link voltage [V], switching frequency [Hz], largest measurable current [A],
        resolution, dead time [s], injected voltage [V]; None: chosen, and the file says so.
    design : DriveDesign
        Its injection loop is what the injected voltage is chosen for.

    Raises
    ------
    UserError
        Numbers that contradict each other, are missing or out of range, or no saliency.
    """
    for label, value in (
        ("speed", sheet.speed_rpm), ("current", sheet.current_rms), ("power", sheet.power),
        ("torque", sheet.torque), ("r", sheet.R), ("ke", sheet.ke), ("kt", sheet.kt),
        ("l-d", sheet.L_d), ("l-q", sheet.L_q), ("l", sheet.L), ("ratio", sheet.ratio),
        ("inertia", sheet.inertia), ("u-dc", u_dc), ("pwm", pwm_hz), ("adc-range", adc_range),
        ("u-inj", u_inj),
    ):  # fmt: skip
        if value is not None:
            check_number(label, value)
    numbers = machine_numbers(sheet)
    tau, i_rated = numbers["tau_rated"].value, numbers["i_rated"].value
    omega = sheet.speed_rpm * RPM_TO_RAD_S
    numbers.setdefault("J", Number(START_TIME * tau / omega,
        f"assumed: {START_TIME:g} s from rest to rated speed at rated torque"))  # fmt: skip
    numbers["B"] = Number(0.01 * tau / omega, "assumed: 1 % of rated torque at rated speed")
    numbers["u_dc"] = Number(u_dc, "given")
    numbers |= _inverter(i_rated, u_dc, 1.0 / pwm_hz, adc_range, adc_bits, dead_time)
    numbers["u_inj"] = Number(u_inj if u_inj is not None else 0.1 * u_dc, "given")
    power = f"{tau * omega:.3g} W" if tau * omega < 1e3 else f"{tau * omega / 1e3:.3g} kW"
    what = f"{power} at {sheet.speed_rpm:g} r/min, from data-sheet numbers"
    motor = Motor.from_tables(tables(name, what, numbers), name)
    require_sane(motor)
    require_saliency(motor)
    if u_inj is None:
        for _ in range(ROUNDS):  # the loop's bandwidth follows from the voltage
            volt = suggested_injection(motor, derive(motor, design).hfi_pll_hz)
            motor = replace(motor, u_inj=volt)
        why = "chosen: angle noise, converter step at rated current, dead time, switches, u_dc / 5"
        numbers["u_inj"] = Number(volt, why)
    return tables(name, what, numbers)


def _inverter(
    i_rated: float,
    u_dc: float,
    T_s: float,
    adc_range: float | None,
    adc_bits: int,
    dead_time: float | None,
) -> dict[str, Number]:
    low = u_dc < LOW_VOLTAGE
    span = adc_range if adc_range is not None else 2.0 * i_rated
    i_max = min(OVERLOAD * i_rated, ADC_ROOM * span)
    usual = min(0.5e-6 if low else 2e-6, 0.02 * T_s)
    switches = "MOSFETs" if low else "IGBTs"
    return {
        "T_s": Number(T_s, "given: PWM frequency"),
        "adc_range": Number(span, "given" if adc_range is not None else "assumed: twice rated"),
        "adc_bits": Number(adc_bits, "given, or usual for a motor-control microcontroller"),
        "dead_time": Number(dead_time, "given")
        if dead_time is not None
        else Number(usual, f"assumed: usual for {switches}, at most 2 % of T_s"),
        "i_max": Number(i_max, f"chosen: {OVERLOAD:g} times rated, within {ADC_ROOM:g} adc_range"),
        "i_trip": Number(TRIP * i_rated, f"chosen: {TRIP:g} times rated"),
    }  # fmt: skip
