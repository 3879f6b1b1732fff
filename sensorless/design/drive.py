"""The drive as a user describes it, and the C parameters it becomes."""

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from sensorless.core.api import CONTROL, PLANT, SENSOR, Array, enumeration
from sensorless.design.control import design_control, design_curves, operating_line
from sensorless.design.cross_coupling import KINDS, is_known
from sensorless.design.sound import require_finite
from sensorless.errors import UserError
from sensorless.machine.magnetics import flux_map_record
from sensorless.machine.motor import Motor
from sensorless.machine.saliency import require_saliency
from sensorless.observers.flux_design import design_flux
from sensorless.observers.hfi_design import SCHEMES, design_hfi, hf_current
from sensorless.observers.smo_design import deadbeat_gain, design_smo, low_pass
from sensorless.observers.start_design import design_start

SUB_STEPS = 1
"""Runge-Kutta steps of the machine a PWM period."""

ESTIMATORS = enumeration("ESTIMATE_")
"""By the name of what estimates beside the injection."""

RENAMED = {"angles": "smo"}
"""Names that estimators no longer have, and the ones they have now."""


def _setting(default: float, doc: str, low: float, high: float) -> Any:
    return field(default=default, metadata={"doc": doc, "low": low, "high": high})


@dataclass(frozen=True)
class DriveDesign:
    """Bandwidths and choices of the control core; everything else follows from the motor."""

    hfi_pll_hz: float = _setting(15.0, "natural frequency of the injection PLL [Hz]", 1, 200)
    smo_pll_hz: float = _setting(20.0, "natural frequency of the EMF PLL [Hz]", 1, 200)
    smo_gain: float = _setting(1.0, "SMO gain over the deadbeat gain L_d / T_s", 0.05, 1.95)
    smo_cross_hz: float = _setting(20.0, "low-pass on the cross term's speed [Hz]", 0.5, math.inf)
    smo_k: float = _setting(2.5, "bound on the SMO's EMF over the rated no-load EMF", 0.05, 100)
    smo_emf_hz: float = _setting(math.inf, "low-pass on the EMF [Hz]", 1, math.inf)
    L_q_bias: float = _setting(0.7, "observer's q inductance over the apparent one", 0.3, 1.5)
    smo_floor_rpm: float = _setting(
        40.0, "speed below which the EMF is not used [r/min]; 0: no warm start", 0, 1e4
    )
    error_pll_hz: float = _setting(25.0, "the one PLL of estimator=errors [Hz]", 1, 200)
    flux_pll_hz: float = _setting(60.0, "speed estimation of the flux observer [Hz]", 0.5, 200)
    flux_gain: float = _setting(0.2, "rise of the flux correction with speed", 0, 5)
    speed_bound: float = _setting(2.5, "bound on estimated speeds over rated", 0.5, math.inf)
    speed_hz: float = _setting(2.5, "natural frequency of the speed loop [Hz]", 0.1, 50)
    speed_weight: float = _setting(0.0, "reference weight of the speed loop", 0, 1)
    current_hz: float = _setting(120.0, "bandwidth of the current loop [Hz]", 10, 1000)
    i_q_slew: float = _setting(150.0, "slope limit of the torque current [A/s]", 1, 1e6)
    k_s_slew: float = _setting(50.0, "slope limit of the weight [1/s]", 1, 5000)
    injection_hold: float = _setting(0.02, "injection after the weight reached zero [s]", 0, 10)
    signal_hz: float = _setting(30.0, "low-pass of the signals a schedule sees [Hz]", 1, 1000)
    dead_time_share: float = _setting(0.75, "share of the dead time compensated", 0, 1)
    hfi_scheme: str = "rotating"
    """Alternating current: second difference in the rotating frame, or as published (Eq. 9) the
    first one in the stationary frame."""
    hfi_delay_cure: bool = True
    """Injected voltage turned by the 1.5 periods of its delay."""
    hfi_normalised: bool = True
    """Error signal over the magnitude of the current's answer (Eq. 7), not as it is (Eq. 15)."""
    estimator: str = "smo"
    """What estimates beside the injection, and how both become one: the sliding-mode observer
    (smo), its angle weighed with the injection's; the same without wrap, as printed in Eq. 26
    (unwrapped); one loop on weighed error signals (errors); a flux observer for the SMO (flux)."""
    cross_line_torque: float = _setting(
        0.5, "torque that the line of cross=line is fitted up to, over rated", 0.05, 2
    )
    smo_sign: bool = False
    """Signum instead of the sigmoid."""
    lag_cure: bool = True
    """EMF from the exact steady-state relation."""
    L_q_table: bool = True
    """Observer inductance over the torque current instead of the data-sheet constant."""
    cross: str = "table"
    """Cross-coupling compensation: none, line, table, or a file of identify cross-coupling."""
    mtpa: bool = True
    """d current of maximum torque per ampere instead of zero."""
    carrier: bool = False
    """Inverter with the switching instants of a carrier instead of its mean voltage."""

    def __post_init__(self) -> None:
        """Check every number against its range.

        Raises
        ------
        UserError
            Names the field, its value and what is allowed.
        """
        for f in dataclasses.fields(self):
            value = getattr(self, f.name)
            if "low" in f.metadata and not f.metadata["low"] <= value <= f.metadata["high"]:
                raise UserError(
                    f"{f.name}: {value!r}; allowed: {f.metadata['low']:g} to "
                    f"{f.metadata['high']:g}, {f.metadata['doc']}"
                )
        if self.estimator in RENAMED:
            now = RENAMED[self.estimator]
            raise UserError(f"estimator: {self.estimator!r} is now called {now!r}: write {now}")
        for name, allowed in (
            ("hfi_scheme", tuple(SCHEMES)),
            ("estimator", tuple(ESTIMATORS)),
        ):
            if getattr(self, name) not in allowed:
                raise UserError(f"{name}: {getattr(self, name)!r}; allowed: {', '.join(allowed)}")
        if not is_known(self.cross):
            raise UserError(f"cross: {self.cross!r}; allowed: {', '.join(KINDS)}, FILE.json")


def control_record(motor: Motor, design: DriveDesign) -> Array:
    """``drive_params_t`` of a motor under a design, shape ().

    Raises
    ------
    UserError
        The machine has no saliency, or its numbers leave those of the drive.
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
        sign=design.smo_sign,
        lag_cure=design.lag_cure,
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
            "control": {**control, "i_d_mtpa": {"y": i_d}},
            "signal": {
                "alpha": low_pass(design.signal_hz, motor.T_s),
                "alpha_per_s": alpha,
                "inv_omega": 1.0 / motor.omega_rated,
                "inv_i": 1.0 / motor.i_rated,
                "inv_e": 1.0 / (motor.omega_rated * motor.psi_f),
                "inv_i_hf": 1.0 / hf_current(motor),
            },
            "L_q": {"y": design.L_q_bias * L_q},
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
    """Write nested values into a structured record; an unknown name raises.

    Raises
    ------
    UserError
        A whole number leaves 32 bits.
    """
    for name, value in values.items():
        if isinstance(value, dict):
            fill(record[name], value)
            continue
        try:
            with np.errstate(over="ignore"):  # infinity: ``require_finite`` tells
                record[name] = value
        except OverflowError:
            raise UserError(f"{name}: {value:g}; allowed: a 32-bit number") from None
