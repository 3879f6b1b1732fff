"""From a machine and a design to the parameters of the C core."""

import math
from functools import lru_cache
from typing import Any

import numpy as np

from sensorless.core.api import CONTROL, PLANT, SENSOR, Array
from sensorless.core.bring_up import PARAMS as BRING_UP
from sensorless.design.control import design_control, design_curves, operating_line, weakening
from sensorless.design.derived import derive, injection_loop
from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.design.guard import design_guard
from sensorless.design.sound import require_finite
from sensorless.errors import UserError
from sensorless.machine.magnetics import plant_map
from sensorless.machine.motor import Motor
from sensorless.machine.saliency import require_saliency
from sensorless.machine.sane import require_sane
from sensorless.observers.bring_up_design import design_bring_up
from sensorless.observers.coupled_design import Bandwidths, design_coupled, load_pole
from sensorless.observers.flux_design import design_flux
from sensorless.observers.hfi_design import design_hfi, hf_current
from sensorless.observers.injection_signal import adc_step
from sensorless.observers.lock_design import design_lock
from sensorless.observers.smo_design import deadbeat_gain, design_smo, low_pass
from sensorless.observers.start_design import design_start
from sensorless.observers.tracking import rated_acceleration

SUB_STEPS = 1
"""Runge-Kutta steps of the machine a PWM period."""
GOOD_NOISE = 0.005
"""Noise of good current sensors, RMS [A]: of every machine, whatever its rated current."""


def control_record(motor: Motor, design: DriveDesign) -> Array:
    """``drive_params_t`` of a motor under a design, shape ().

    Raises
    ------
    UserError
        The machine has no saliency, is none at all, or a number overflows 32 bits.
    """
    kept = design.cross in ("none", "line", "table")  # else a file, which may change
    return (designed if kept else designed.__wrapped__)(motor, design).copy()


@lru_cache(maxsize=64)
def designed(motor: Motor, design: DriveDesign) -> Array:
    """``control_record``, shared: not to be changed."""
    require_sane(motor)
    require_saliency(motor)
    by = derive(motor, design)
    omega_max = min(design.speed_bound * motor.omega_rated, float(np.finfo(np.float32).max))
    one_loop = by.error_pll_hz if design.estimator == "errors" else None
    record = np.zeros((), dtype=CONTROL)
    line = operating_line(motor, design.mtpa)
    i_d, L_q, cross = design_curves(
        motor,
        line,
        L_q_table=design.L_q_table,
        cross=design.cross,
        cross_torque=design.cross_line_torque,
    )
    control = design_control(
        motor,
        speed_hz=by.speed_hz,
        speed_weight=design.speed_weight,
        current_hz=by.current_hz,
        i_q_slew=by.i_q_slew,
        u_dt=by.dead_time_share * motor.dead_time_voltage,
    )
    smo = design_smo(
        motor,
        pll_hz=one_loop or by.smo_pll_hz,
        gain=design.smo_gain * deadbeat_gain(motor),
        k=design.smo_k * motor.omega_rated * motor.psi_f,
        cross_hz=by.smo_cross_hz,
        emf_hz=design.smo_emf_hz,
        floor_rpm=by.smo_floor_rpm,
        switching=design.smo_switching,
        lag_cure=design.lag_cure,
        motoring=design.L_q_motoring / design.L_q_bias,
        omega_max=omega_max,
    )
    natural = injection_loop(motor)
    hfi = design_hfi(
        motor,
        pll_hz=one_loop or by.hfi_pll_hz,
        natural_hz=natural,
        lag=rated_acceleration(motor) / (2.0 * math.pi * natural) ** 2,
        hold=design.injection_hold,
        omega_max=omega_max,
        scheme=design.hfi_scheme,
        delay_cure=design.hfi_delay_cure,
        normalised=design.hfi_normalised,
    )
    flux = design_flux(
        motor,
        pll_hz=by.flux_pll_hz,
        gain=design.flux_gain,
        floor_rpm=by.smo_floor_rpm,
        omega_max=omega_max,
    )
    coupled = design_coupled(
        motor,
        line,
        at=Bandwidths(
            flux=2.0 * math.pi * by.coupled_flux_hz,
            load=load_pole(by.speed_hz),
            injection=2.0 * math.pi * by.coupled_injection_hz,
        ),
        L_q_bias=by.coupled_L_q_bias,
        linear=design.coupled_linear,
        u_dt=control["u_dt"],
        inv_i_comp=control["inv_i_dt"],
        floor_rpm=by.smo_floor_rpm,
        omega_max=omega_max,
    )
    own_bias = {"flux": design.flux_L_q_bias, "coupled": by.coupled_L_q_bias}
    bias = own_bias.get(design.estimator, design.L_q_bias)
    alpha = 2.0 * math.pi * by.signal_hz
    fill(
        record,
        {
            "T_s": motor.T_s,
            "k_s_step": design.k_s_slew * motor.T_s,
            "estimator": ESTIMATORS[design.estimator],
            "guard": design_guard(motor, omega_max, by.speed_hz),
            "hfi": hfi,
            "smo": smo,
            "flux": flux,
            "coupled": coupled,
            "control": {**control, "i_d_mtpa": {"y": i_d}},
            "signal": {
                "alpha": low_pass(by.signal_hz, motor.T_s),
                "alpha_per_s": alpha,
                "inv_omega": 1.0 / motor.omega_rated,
                "inv_i": 1.0 / motor.i_rated,
                "inv_e": 1.0 / (motor.omega_rated * motor.psi_f),
                "inv_i_hf": 1.0 / hf_current(motor),
            },
            "L_q": {"y": bias * L_q},
            "theta_cross": {"y": cross},
            "start": design_start(motor, hfi, smo),
            "lock": design_lock(
                motor,
                action=design.lost_lock,
                bias=bias,
                one_axis=design.estimator in ("coupled", "errors"),
                speed_hz=by.speed_hz,
                current_hz=by.current_hz,
                weakening=weakening(by.speed_hz, by.current_hz),
            ),
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


def sensor_record(motor: Motor, noise_rms: float = GOOD_NOISE) -> Array:
    """``sensor_params_t`` of a motor with noise of ``noise_rms`` [A], shape ()."""
    lsb = adc_step(motor)
    record = np.zeros((), dtype=SENSOR)
    fill(
        record,
        {
            "dead_time_share": motor.dead_time / motor.T_s,
            "inv_i_zero": 1.0 / (0.01 * motor.i_rated),
            "gain_a": 1.0,
            "gain_b": 1.0,
            "noise_rms": noise_rms,
            "lsb": lsb,
            "inv_lsb": 1.0 / lsb,
            "range": motor.adc_range,
        },
    )
    return record


def bring_up_record(motor: Motor) -> Array:
    """``bring_up_params_t`` of a motor, shape ()."""
    record = np.zeros((), dtype=BRING_UP)
    fill(record, design_bring_up(motor))
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
