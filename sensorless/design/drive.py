"""The drive as a user describes it, and the C parameters it becomes."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from sensorless.core.api import CONTROL, PLANT, SENSOR, Array, enumeration
from sensorless.design.control import design_control, design_curves, operating_line
from sensorless.design.sound import require_finite
from sensorless.errors import UserError
from sensorless.machine.magnetics import flux_map_record
from sensorless.machine.motor import Motor
from sensorless.machine.saliency import require_saliency
from sensorless.observers.coupled_design import design_coupled
from sensorless.observers.flux_design import design_flux
from sensorless.observers.hfi_design import design_hfi, hf_current
from sensorless.observers.smo_design import deadbeat_gain, design_smo, low_pass
from sensorless.observers.start_design import design_start
from sensorless.settings import check, number, switch, word

SUB_STEPS = 1
"""Runge-Kutta steps of the machine a PWM period."""

ESTIMATORS = enumeration("ESTIMATE_")
"""Numbers of the C core by the name that the setting ``estimator`` takes."""

RENAMED = {"angles": "smo"}
"""Old names of estimators, and their names now."""


@dataclass(frozen=True)
class DriveDesign:
    """Bandwidths and choices of the control core; everything else follows from the motor."""

    hfi_pll_hz: float = number(15.0, "Hz", 1, 200, "natural frequency of the injection's PLL")
    smo_pll_hz: float = number(20.0, "Hz", 1, 200, "natural frequency of the PLL on the EMF")
    smo_gain: float = number(1.0, "1", 0.05, 1.95, "SMO gain over the deadbeat gain L_d / T_s")
    smo_cross_hz: float = number(
        20.0, "Hz", 0.5, math.inf, "low-pass on the speed in the SMO's cross term", endless=True
    )
    smo_k: float = number(2.5, "1", 0.05, 100, "bound on the SMO's EMF over the rated no-load EMF")
    smo_emf_hz: float = number(
        math.inf, "Hz", 1, math.inf, "low-pass on the EMF; inf: none", endless=True
    )
    L_q_bias: float = number(0.7, "1", 0.3, 1.5, "SMO's q inductance over the apparent one")
    L_q_motoring: float = number(0.9, "1", 0.3, 1.5, "the same as a motor, where that is more")
    smo_floor_rpm: float = number(
        40.0, "r/min", 0, 1e4, "speed below which the EMF is not used; 0: no warm start"
    )
    error_pll_hz: float = number(
        25.0, "Hz", 1, 200, "natural frequency of the one PLL of estimator=errors"
    )
    flux_pll_hz: float = number(
        60.0, "Hz", 0.5, 200, "natural frequency of the flux observer's speed estimate"
    )
    flux_gain: float = number(0.2, "1", 0, 5, "how fast the flux correction rises with speed")
    flux_L_q_bias: float = number(0.9, "1", 0.3, 1.5, "flux observer's L_q over the apparent one")
    coupled_L_q_bias: float = number(0.85, "1", 0.3, 1.5, "coupled one's L_q over the apparent one")
    coupled_linear: bool = switch(
        False, "coupled observer's flux correction without the sigmoid, in proportion to the error"
    )
    speed_bound: float = number(
        2.5, "1", 0.5, math.inf, "bound on estimated speeds over rated speed", endless=True
    )
    speed_hz: float = number(2.5, "Hz", 0.1, 50, "natural frequency of the speed loop")
    speed_weight: float = number(0.0, "1", 0, 1, "reference weight of the speed loop: 0 IP, 1 PI")
    current_hz: float = number(120.0, "Hz", 10, 1000, "bandwidth of the current loop")
    i_q_slew: float = number(150.0, "A/s", 1, 1e6, "slope limit of the torque current")
    k_s_slew: float = number(50.0, "1/s", 1, 5000, "slope limit of the weight k_s")
    injection_hold: float = number(
        0.02, "s", 0, 10, "time the injection stays on after k_s reached zero"
    )
    signal_hz: float = number(30.0, "Hz", 1, 1000, "low-pass on the signals that a schedule sees")
    dead_time_share: float = number(0.75, "1", 0, 1, "share of the dead time that is compensated")
    hfi_scheme: str = word(
        "rotating",
        "how the alternating current is found",
        {
            "rotating": "second difference in the rotating frame",
            "stationary": "first difference in the stationary frame, as published (Eq. 9)",
        },
    )
    hfi_delay_cure: bool = switch(
        True, "turn the injected voltage by the 1.5 periods that it acts late"
    )
    hfi_normalised: bool = switch(
        True,
        "divide the injection's error signal by the magnitude of the current's answer (Eq. 7); "
        "false: as it is (Eq. 15)",
    )
    estimator: str = word(
        "coupled",
        "what estimates beside the injection, and how both become one",
        {
            "smo": "sliding-mode observer, angles weighed",
            "unwrapped": "the same without wrap, as printed (Eq. 26)",
            "errors": "sliding-mode observer and injection in one loop, error signals weighed",
            "flux": "flux observer, angles weighed",
            "coupled": "one observer of flux and speed, corrected by injection with the weight",
        },
        renamed=RENAMED,
    )
    cross_line_torque: float = number(
        0.5, "1", 0.05, 2, "torque over rated that the line of cross=line is fitted up to"
    )
    smo_switching: str = word(
        "sigmoid",
        "what corrects the SMO's current",
        {
            "sigmoid": "linear inside a boundary layer (Eq. 24)",
            "sign": "signum (Eq. 22): slides, chatters",
            "super_twisting": "slides in the second order, its gains follow the speed",
        },
        was="smo_sign",
    )
    lag_cure: bool = switch(True, "EMF from the exact steady-state relation")
    L_q_table: bool = switch(
        True, "observer's q inductance over the torque current; false: the data sheet's constant"
    )
    cross: str = word(
        "table",
        "compensation of cross-coupling",
        {
            "none": "no compensation",
            "line": "a line through zero",
            "table": "that of the flux map",
            "FILE.json": "as sensorless identify cross-coupling measured it",
        },
    )
    mtpa: bool = switch(True, "d current of maximum torque per ampere; false: zero")
    carrier: bool = switch(
        False, "inverter with the switching instants of a carrier; false: with its mean voltage"
    )

    def __post_init__(self) -> None:
        """Check every setting.

        Raises
        ------
        UserError
            Names the setting, its value and what it must be.
        """
        check(self)


def control_record(motor: Motor, design: DriveDesign) -> Array:
    """``drive_params_t`` of a motor under a design, shape ().

    Raises
    ------
    UserError
        The machine has no saliency, or a number overflows 32 bits.
    """
    require_saliency(motor)
    omega_max = min(design.speed_bound * motor.omega_rated, float(np.finfo(np.float32).max))
    one_loop = design.error_pll_hz if design.estimator == "errors" else None
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
        speed_hz=design.speed_hz,
        speed_weight=design.speed_weight,
        current_hz=design.current_hz,
        i_q_slew=design.i_q_slew,
        u_dt=design.dead_time_share * motor.u_dc * motor.dead_time / motor.T_s,
    )
    smo = design_smo(
        motor,
        pll_hz=one_loop or design.smo_pll_hz,
        gain=design.smo_gain * deadbeat_gain(motor),
        k=design.smo_k * motor.omega_rated * motor.psi_f,
        cross_hz=design.smo_cross_hz,
        emf_hz=design.smo_emf_hz,
        floor_rpm=design.smo_floor_rpm,
        switching=design.smo_switching,
        lag_cure=design.lag_cure,
        motoring=design.L_q_motoring / design.L_q_bias,
        omega_max=omega_max,
    )
    hfi = design_hfi(
        motor,
        pll_hz=one_loop or design.hfi_pll_hz,
        hold=design.injection_hold,
        omega_max=omega_max,
        scheme=design.hfi_scheme,
        delay_cure=design.hfi_delay_cure,
        normalised=design.hfi_normalised,
    )
    flux = design_flux(
        motor,
        pll_hz=design.flux_pll_hz,
        gain=design.flux_gain,
        floor_rpm=design.smo_floor_rpm,
        omega_max=omega_max,
    )
    coupled = design_coupled(
        motor,
        line,
        speed_hz=design.speed_hz,
        linear=design.coupled_linear,
        u_dt=control["u_dt"],
        inv_i_comp=control["inv_i_dt"],
        floor_rpm=design.smo_floor_rpm,
        omega_max=omega_max,
    )
    own_bias = {"flux": design.flux_L_q_bias, "coupled": design.coupled_L_q_bias}
    bias = own_bias.get(design.estimator, design.L_q_bias)
    alpha = 2.0 * math.pi * design.signal_hz
    fill(
        record,
        {
            "T_s": motor.T_s,
            "k_s_step": design.k_s_slew * motor.T_s,
            "estimator": ESTIMATORS[design.estimator],
            "hfi": hfi,
            "smo": smo,
            "flux": flux,
            "coupled": coupled,
            "control": {**control, "i_d_mtpa": {"y": i_d}},
            "signal": {
                "alpha": low_pass(design.signal_hz, motor.T_s),
                "alpha_per_s": alpha,
                "inv_omega": 1.0 / motor.omega_rated,
                "inv_i": 1.0 / motor.i_rated,
                "inv_e": 1.0 / (motor.omega_rated * motor.psi_f),
                "inv_i_hf": 1.0 / hf_current(motor),
            },
            "L_q": {"y": bias * L_q},
            "theta_cross": {"y": cross},
            "start": design_start(motor, hfi, smo),
        },
    )
    require_finite(record, motor)
    return record


def plant_record(motor: Motor) -> Array:
    """``plant_params_t`` of a motor, shape ()."""
    record = np.zeros((), dtype=PLANT)
    record["map"] = flux_map_record(motor.saturation)
    fill(
        record,
        {
            "R_s": motor.R_s,
            "n_p": motor.n_p,
            "inv_J": 1.0 / motor.J,
            "B": motor.B,
            "h": motor.T_s / SUB_STEPS,
            "n_sub": SUB_STEPS,
            "bridge": int(motor.saturation.a_b > 0.0),
            "k_iron": 1.0,
        },
    )
    return record


def sensor_record(motor: Motor, noise_rms: float = 0.005) -> Array:
    """``sensor_params_t`` of a motor with noise of ``noise_rms`` [A], shape ()."""
    lsb = 2.0 * motor.adc_range / 2**motor.adc_bits
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
