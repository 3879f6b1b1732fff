"""From a machine and a design to the parameters of the C core."""

from functools import lru_cache
from typing import Any

import numpy as np

from sensorless.core.api import CONTROL, PLANT, SENSOR, Array
from sensorless.core.bring_up import PARAMS as BRING_UP
from sensorless.design.blocks import (
    control_block,
    coupled_block,
    flux_block,
    hfi_block,
    largest_speed,
    lock_block,
    own_q_bias,
    signal_block,
    smo_block,
)
from sensorless.design.control import design_curves, operating_line
from sensorless.design.derived import derive
from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.design.guard import design_guard
from sensorless.design.sound import require_finite
from sensorless.errors import UserError
from sensorless.machine.magnetics import plant_map
from sensorless.machine.motor import Motor
from sensorless.machine.saliency import require_saliency
from sensorless.machine.sane import require_sane
from sensorless.observers.bring_up_design import design_bring_up
from sensorless.observers.injection_signal import NOISE_AT, adc_step
from sensorless.observers.start_design import design_start

SUB_STEPS = 1
"""Runge-Kutta steps of the machine a PWM period."""
TURNS_ROUND = 0.01
"""Phase current, over rated, from which a leg loses all of its dead time: below, the current turns
round within a period."""
GOOD_NOISE = 0.005
"""Noise of good current sensors on a machine rated at ``NOISE_AT``, RMS [A]; that of others goes
with their rated current, as the sensors that are chosen for it."""


def reference_most(motor: Motor, design: DriveDesign) -> float:
    """Largest speed reference that a drive follows, mechanical [rad/s]; errors as below."""
    return float(control_record(motor, design)["guard"]["omega"]) / motor.n_p


def control_record(motor: Motor, design: DriveDesign) -> Array:
    """``drive_params_t`` of a motor under a design, shape ().

    Raises
    ------
    UserError
        The machine is impossible or has no saliency, or a number overflows 32 bits.
    """
    kept = design.cross in ("none", "line", "table")  # else a file, which may change
    return (designed if kept else designed.__wrapped__)(motor, design).copy()


@lru_cache(maxsize=64)
def designed(motor: Motor, design: DriveDesign) -> Array:
    """``control_record``, shared: not to be changed."""
    require_sane(motor)
    require_saliency(motor)
    by = derive(motor, design)
    record = np.zeros((), dtype=CONTROL)
    line = operating_line(motor, design.mtpa)
    i_d, L_q, cross = design_curves(
        motor,
        line,
        L_q_table=design.L_q_table,
        cross=design.cross,
        cross_torque=design.cross_line_torque,
    )
    control = control_block(motor, design, by)
    smo = smo_block(motor, design, by)
    hfi = hfi_block(motor, design, by)
    bias = own_q_bias(design, by)
    fill(
        record,
        {
            "T_s": motor.T_s,
            "k_s_step": design.k_s_slew * motor.T_s,
            "estimator": ESTIMATORS[design.estimator],
            "guard": design_guard(motor, largest_speed(motor, design), by.speed_hz),
            "hfi": hfi,
            "smo": smo,
            "flux": flux_block(motor, design, by),
            "coupled": coupled_block(motor, design, by, line, control),
            "control": {**control, "i_d_mtpa": {"y": i_d}},
            "signal": signal_block(motor, by),
            "L_q": {"y": bias * L_q},
            "theta_cross": {"y": cross},
            "start": design_start(motor, hfi, smo),
            "lock": lock_block(motor, design, by, bias),
        },
    )
    require_finite(record, motor)
    record.flags.writeable = False
    return record


def plant_record(motor: Motor) -> Array:
    """``plant_params_t`` of a motor, shape ()."""
    record = np.zeros((), dtype=PLANT)
    record["map"], extra = plant_map(motor)
    fill(
        record,
        {
            "R_s": motor.R_s,
            "n_p": motor.n_p,
            "inv_J": 1.0 / motor.J,
            "B": motor.B,
            "h": motor.T_s / SUB_STEPS,
            "n_sub": SUB_STEPS,
            "extra": extra,
            "k_iron": 1.0,
        },
    )
    return record


def good_noise(motor: Motor) -> float:
    """Noise of good current sensors, RMS [A]; see ``GOOD_NOISE``."""
    return GOOD_NOISE * (motor.i_rated / NOISE_AT)


def sensor_record(motor: Motor) -> Array:
    """``sensor_params_t`` of a motor, with the noise of good sensors, shape ()."""
    lsb = adc_step(motor)
    record = np.zeros((), dtype=SENSOR)
    fill(
        record,
        {
            "dead_time_share": motor.dead_time / motor.T_s,
            "inv_i_zero": 1.0 / (TURNS_ROUND * motor.i_rated),
            "gain_a": 1.0,
            "gain_b": 1.0,
            "noise_rms": good_noise(motor),
            "lsb": lsb,
            "inv_lsb": 1.0 / lsb,
            "range": motor.adc_range,
        },
    )
    return record


def bring_up_record(motor: Motor, compensates: bool = True) -> Array:
    """``bring_up_params_t`` of a motor, shape ().

    A drive that does not compensate its dead time leaves that to the driver: it is not judged.
    """
    record = np.zeros((), dtype=BRING_UP)
    fill(record, design_bring_up(motor) | ({} if compensates else {"u_lost": 0.0}))
    return record


def fill(record: Array, values: dict[str, Any]) -> None:
    """Write nested values; raises on an unknown name, UserError if a number exceeds 32 bits."""
    for name, value in values.items():
        if isinstance(value, dict):
            fill(record[name], value)
            continue
        try:
            with np.errstate(over="ignore"):  # ``require_finite`` reports infinity
                record[name] = value
        except OverflowError:
            raise UserError(
                f"{name} of the drive: {value:g} does not fit into 32 bits; give the machine in SI "
                "units, and try sensorless motor check"
            ) from None
