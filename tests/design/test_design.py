"""From bandwidths to coefficients: the numbers of the observers' and the control's design."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sensorless.design.control import design_curves, operating_line, torque_constant
from sensorless.design.drive import ESTIMATORS, RENAMED, DriveDesign
from sensorless.design.records import control_record, plant_record, sensor_record
from sensorless.design.words import OBSERVERS, observer_name
from sensorless.errors import UserError
from sensorless.machine.motor import Motor, Saturation
from sensorless.observers.hfi_design import SCHEMES, error_slope, hf_current
from sensorless.observers.pll_design import pll_gains
from sensorless.observers.smo_design import SWITCHING, deadbeat_gain, low_pass
from sensorless.settings import Setting, settings_of

NUMBERS = [s for s in settings_of(DriveDesign).values() if s.kind is float]


def test_every_estimator_has_a_name_for_people() -> None:
    assert set(OBSERVERS) == set(ESTIMATORS)
    assert observer_name("flux") == "flux observer"


@pytest.mark.parametrize(
    ("hertz", "hfi", "smo"),
    [
        (10.0, (114, 5063), (88.9, 3948)),
        (20.0, (228, 20253), (178, 15791)),
        (30.0, (342, 45568), (267, 35531)),
        (50.0, (570, 126579), (444, 98696)),
    ],
)
def test_pll_gains(
    motor: Motor, hertz: float, hfi: tuple[float, float], smo: tuple[float, float]
) -> None:
    """Table of gains for both error slopes, 0.780 and 1."""
    slope = error_slope(motor.L_d, motor.L_q)
    assert slope == pytest.approx(0.780, abs=5e-4)
    assert pll_gains(hertz, slope) == pytest.approx(hfi, rel=3e-3)
    assert pll_gains(hertz, 1.0) == pytest.approx(smo, rel=3e-3)


def test_injected_current(motor: Motor) -> None:
    """79.37 mA at 50 V and 0.2 ms."""
    assert hf_current(motor) == pytest.approx(79.37e-3, abs=5e-6)


def test_deadbeat_gain(motor: Motor) -> None:
    """L_d / T_s = 315 V/A."""
    assert deadbeat_gain(motor) == pytest.approx(315.0)


@pytest.mark.parametrize(
    ("name", "want"),
    [
        ("paper", 3.0 * 0.993 * 2),
        ("ipmsm_2200w", 4.5 * 0.545 * 3),
        ("pmsyrm_5600w", 2 * 29.7 / 8.527),
    ],
)
def test_torque_constant(name: str, want: float) -> None:
    """The magnet's where it makes rated torque alone; else that of the rated point."""
    assert torque_constant(Motor.load(name)) == pytest.approx(want, rel=1e-3)


@pytest.mark.parametrize(("hertz", "want"), [(math.inf, 1.0), (30.0, 0.03700), (1e6, 1.0)])
def test_low_pass(hertz: float, want: float) -> None:
    """Exact discretisation of a first-order low-pass."""
    assert low_pass(hertz, 2e-4) == pytest.approx(want, abs=1e-5)


def test_records_carry_the_design(motor: Motor) -> None:
    """What was asked for stands in the C parameters."""
    design = DriveDesign(hfi_pll_hz=25.0, smo_pll_hz=15.0, smo_gain=0.5, k_s_slew=40.0)
    record = control_record(motor, design)
    w_hfi, w_smo = 2.0 * math.pi * 25.0, 2.0 * math.pi * 15.0
    slope = 1.0 - motor.L_d / motor.L_q
    assert record["hfi"]["pll"]["k_i"] == pytest.approx(w_hfi**2 / slope, rel=1e-6)
    assert record["smo"]["pll"]["k_p"] == pytest.approx(math.sqrt(2.0) * w_smo, rel=1e-6)
    assert record["smo"]["k"] * record["smo"]["half_a"] == pytest.approx(157.5, rel=1e-6)
    assert record["smo"]["k"] > motor.omega_rated * motor.psi_f
    assert record["k_s_step"] == pytest.approx(40.0 * motor.T_s)
    assert record["T_s"] == pytest.approx(motor.T_s)


def test_plant_and_sensor_records(motor: Motor) -> None:
    """Numbers of the machine file arrive in the simulation."""
    plant, sensor = plant_record(motor), sensor_record(motor)
    assert [plant["R_s"], plant["n_p"], plant["B"]] == [motor.R_s, motor.n_p, motor.B]
    assert plant["inv_J"] == pytest.approx(1.0 / motor.J)
    assert plant["h"] * plant["n_sub"] == pytest.approx(motor.T_s)
    assert plant["extra"] == 0
    assert sensor["lsb"] == pytest.approx(20.0 / 4096)
    assert sensor["noise_rms"] == pytest.approx(0.005)
    assert sensor["dead_time_share"] == pytest.approx(0.01)


@pytest.mark.parametrize("setting", NUMBERS, ids=lambda s: s.name)
def test_design_ranges(setting: Setting) -> None:
    """A number outside of its range, or NaN, is refused with name, value and range."""
    low, high = setting.low, setting.high
    bad = [low - 1.0 - abs(low), math.nan] + ([2.0 * high + 1.0] if math.isfinite(high) else [])
    for value in bad:
        wrong: dict[str, Any] = {setting.name: value}
        with pytest.raises(UserError) as error:
            DriveDesign(**wrong)
        assert str(error.value).startswith(f"{setting.name}: {value!r}: must be ")
    right: dict[str, Any] = {setting.name: low}
    assert getattr(DriveDesign(**right), setting.name) == low


def test_unknown_compensation_is_refused() -> None:
    """A word has its list of words."""
    with pytest.raises(
        UserError, match=r"cross: 'spline': must be none, line, table or FILE\.json"
    ):
        DriveDesign(cross="spline")


def test_every_word_has_its_code() -> None:
    """What may be said is what the core knows."""
    known = settings_of(DriveDesign)
    assert set(known["estimator"].choices) == set(ESTIMATORS)
    assert set(known["hfi_scheme"].choices) == set(SCHEMES)
    assert set(known["smo_switching"].choices) == set(SWITCHING)


def test_an_old_name_of_an_estimator_is_refused_with_the_new_one() -> None:
    with pytest.raises(UserError, match="estimator: 'angles' is now called 'smo'"):
        DriveDesign(estimator="angles")
    assert not set(RENAMED) & set(ESTIMATORS)
    for now in RENAMED.values():
        DriveDesign(estimator=now)


def test_operating_line(motor: Motor) -> None:
    """Evenly spaced torque currents to i_max; i_d by maximum torque per ampere or zero."""
    line = operating_line(motor, use_mtpa=True)
    assert np.diff(line[1:, 1]) == pytest.approx(motor.i_max / 8)
    assert line[-1, 1] == pytest.approx(motor.i_max)
    assert np.all(line[1:, 0] < 0.0)
    assert np.all(operating_line(motor, use_mtpa=False)[:, 0] == 0.0)


def test_line_compensation(motor: Motor) -> None:
    """A line through zero of -3.29 degrees per ampere, fitted up to rated current at i_d = 0."""
    fine = np.stack([np.zeros(400), np.linspace(0.0, motor.i_rated, 401)[1:]], axis=-1)
    _, _, angle = design_curves(
        motor, np.concatenate([fine[:1], fine]), L_q_table=True, cross="line", cross_torque=1.053
    )
    slope = np.rad2deg(angle[-1]) / fine[-1, 1]
    assert slope == pytest.approx(-3.29, abs=0.04)
    assert np.rad2deg(angle[1:]) == pytest.approx(slope * fine[:, 1])


@pytest.mark.parametrize("cross", ["none", "table"])
def test_compensation_curve(motor: Motor, cross: str) -> None:
    """None is zero; the table holds the machine's own angle at its nodes."""
    line = operating_line(motor, use_mtpa=False)
    _, L_q, angle = design_curves(motor, line, L_q_table=False, cross=cross)
    assert np.all(motor.L_q == L_q)
    want = 0.0 if cross == "none" else -19.8
    at = np.interp(2.0 * 5.6286, line[:, 1], np.rad2deg(angle))
    if cross == "none":
        assert np.all(angle == 0.0)
    else:
        full = operating_line(replace(motor, i_max=2.0 * 5.6286), use_mtpa=False)
        _, _, wide = design_curves(motor, full, L_q_table=False, cross=cross)
        assert np.rad2deg(wide[-1]) == pytest.approx(want, abs=0.06)
        assert at == np.rad2deg(angle[-1])


DESIGNED = ("R_s", "L_d", "L_q", "psi_f", "J", "i_rated", "tau_rated", "n_rated_rpm", "u_dc", "T_s")


@pytest.mark.parametrize("field", DESIGNED)
@pytest.mark.parametrize("value", [1.1e-12, 1e-6, 1e-3, 1e6, 9e11])
def test_absurd_numbers_end_in_a_design_or_in_one_line(field: str, value: float) -> None:
    """Whatever a file may hold: 32-bit numbers all of them, or one error, and no warning."""
    value = min(max(value, 1e-6), 1e-3) if field == "T_s" else value
    changed: dict[str, Any] = {field: value}
    motor = replace(Motor.load("ipmsm_2200w"), **changed)
    flux_map = Saturation.linear(motor.L_d, motor.L_q, motor.psi_f)
    try:
        record = control_record(replace(motor, saturation=flux_map), DriveDesign())
    except UserError as error:
        assert "\n" not in str(error)
        return
    floats = np.frombuffer(record.tobytes(), dtype=np.float32)
    assert not np.any(np.isinf(floats))
