"""Parameters of the drive's blocks: each takes from machine, design and formulas what it needs."""

import math
from typing import Any

import numpy as np

from sensorless.design.control import design_control, weakening
from sensorless.design.derived import Derived, injection_loop
from sensorless.design.drive import DriveDesign
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.observers.coupled_design import Bandwidths, design_coupled, load_pole
from sensorless.observers.flux_design import design_flux
from sensorless.observers.hfi_design import design_hfi, hf_current
from sensorless.observers.lock_design import design_lock
from sensorless.observers.smo_design import deadbeat_gain, design_smo, low_pass
from sensorless.observers.tracking import rated_acceleration

Fields = dict[str, Any]


def largest_speed(motor: Motor, design: DriveDesign) -> float:
    """Bound of every speed estimate, electrical [rad/s]; at most what 32 bits hold."""
    return min(design.speed_bound * motor.omega_rated, float(np.finfo(np.float32).max))


def control_block(motor: Motor, design: DriveDesign, by: Derived) -> Fields:
    """Fields of ``control_params_t`` but for the currents of the operating line."""
    return design_control(
        motor,
        speed_hz=by.speed_hz,
        speed_weight=design.speed_weight,
        current_hz=by.current_hz,
        i_q_slew=by.i_q_slew,
        u_dt=by.dead_time_share * motor.dead_time_voltage,
        omega_max=largest_speed(motor, design),
    )


def smo_block(motor: Motor, design: DriveDesign, by: Derived) -> Fields:
    """Fields of ``smo_params_t``, of the sliding-mode observer."""
    return design_smo(
        motor,
        pll_hz=_weighed_errors(design, by) or by.smo_pll_hz,
        gain=design.smo_gain * deadbeat_gain(motor),
        k=design.smo_k * motor.omega_rated * motor.psi_f,
        cross_hz=by.smo_cross_hz,
        emf_hz=design.smo_emf_hz,
        floor_rpm=by.smo_floor_rpm,
        switching=design.smo_switching,
        lag_cure=design.lag_cure,
        motoring=design.L_q_motoring / design.L_q_bias,
        omega_max=largest_speed(motor, design),
    )


def hfi_block(motor: Motor, design: DriveDesign, by: Derived) -> Fields:
    """Fields of ``hfi_params_t``, of the injection estimator."""
    natural = injection_loop(motor)
    return design_hfi(
        motor,
        pll_hz=_weighed_errors(design, by) or by.hfi_pll_hz,
        natural_hz=natural,
        lag=rated_acceleration(motor) / (2.0 * math.pi * natural) ** 2,
        hold=design.injection_hold,
        omega_max=largest_speed(motor, design),
        scheme=design.hfi_scheme,
        delay_cure=design.hfi_delay_cure,
        normalised=design.hfi_normalised,
    )


def flux_block(motor: Motor, design: DriveDesign, by: Derived) -> Fields:
    """Fields of ``flux_params_t``, of the flux observer."""
    return design_flux(
        motor,
        pll_hz=by.flux_pll_hz,
        gain=design.flux_gain,
        floor_rpm=by.smo_floor_rpm,
        omega_max=largest_speed(motor, design),
    )


def coupled_block(
    motor: Motor, design: DriveDesign, by: Derived, line: Floats, control: Fields
) -> Fields:
    """Fields of ``coupled_params_t``, of the coupled observer.

    Parameters
    ----------
    line : (n, 2) currents of the operating line [A]
    control : fields of ``control_block``
        The observer knows the dead time as the control does.
    """
    return design_coupled(
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
        omega_max=largest_speed(motor, design),
    )


def signal_block(motor: Motor, by: Derived) -> Fields:
    """Fields of ``signal_params_t``: the low-pass and the scales of a schedule's signals."""
    return {
        "alpha": low_pass(by.signal_hz, motor.T_s),
        "alpha_per_s": 2.0 * math.pi * by.signal_hz,
        "inv_omega": 1.0 / motor.omega_rated,
        "inv_i": 1.0 / motor.i_rated,
        "inv_e": 1.0 / (motor.omega_rated * motor.psi_f),
        "inv_i_hf": 1.0 / hf_current(motor),
    }


def lock_block(motor: Motor, design: DriveDesign, by: Derived, bias: float) -> Fields:
    """Fields of ``lock_params_t``; ``bias`` is the observer's q inductance over the apparent."""
    return design_lock(
        motor,
        action=design.lost_lock,
        bias=bias,
        one_axis=design.estimator in ("coupled", "errors"),
        i_q_slew=by.i_q_slew,
        current_hz=by.current_hz,
        weakening=weakening(by.speed_hz, by.current_hz),
    )


def own_q_bias(design: DriveDesign, by: Derived) -> float:
    """q inductance of the design's estimator over the apparent one."""
    own = {"flux": design.flux_L_q_bias, "coupled": by.coupled_L_q_bias}
    return own.get(design.estimator, design.L_q_bias)


def _weighed_errors(design: DriveDesign, by: Derived) -> float | None:
    """Natural frequency [Hz] of the one PLL on both errors; None where each has its own."""
    return by.error_pll_hz if design.estimator == "errors" else None
