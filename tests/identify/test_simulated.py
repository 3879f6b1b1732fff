"""The simulated drive as a source of measurements, and what the procedure makes of its fits."""

import dataclasses
from typing import Any

import numpy as np
import pytest

from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.stress import stress_scenarios
from sensorless.errors import UserError
from sensorless.identify.machine import procedure
from sensorless.identify.machine.curves import fit_curves
from sensorless.identify.machine.electric import Sensors
from sensorless.identify.machine.joint import Joint, fit_jointly
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.procedure import Identified, identify_machine
from sensorless.identify.machine.simulated import Simulated, real_drive
from sensorless.identify.machine.source import Gains, Recorded, amps, volts
from sensorless.identify.machine.spin import Spin, measure_spin
from sensorless.machine.motor import Motor

MOTOR = Motor.load("ipmsm_2200w")
PLATE = Nameplate.of(MOTOR)
OF_DRIVE = ("dead_time", "noise", "gain", "offset", "theta_0")
OF_MACHINE = ("emf_5", "emf_7", "saliency_6", "p_iron", "ripple")


@pytest.mark.parametrize("details", [False, True])
def test_a_drive_has_the_errors_of_the_suite(details: bool) -> None:
    seeds = np.array([7], dtype=np.uint64)
    s, drawn = real_drive(MOTOR, 7, details), stress_scenarios(MOTOR, seeds)
    plain = Scenarios.nominal(MOTOR, seeds, 1.0)
    for name in (*OF_DRIVE, *OF_MACHINE):
        from_suite = details or name in OF_DRIVE
        assert np.array_equal(getattr(s, name), getattr(drawn if from_suite else plain, name))
        assert not np.array_equal(getattr(drawn, name), getattr(plain, name)), name
    for name in ("J", "R_s", "omega", "tau"):
        assert np.array_equal(getattr(s, name), getattr(plain, name))


def test_a_seed_out_of_range_is_refused() -> None:
    with pytest.raises(UserError, match="seed"):
        real_drive(MOTOR, -1)


def test_a_current_beyond_the_limit_is_refused() -> None:
    """100 V over 2.5 ohm is 40 A, and it stops at 98 % of the 12 A that the sensors see."""
    source = Simulated(MOTOR, real_drive(MOTOR, 3))
    with pytest.raises(UserError, match="stage probe: current above"):
        source.run("probe", [volts(0.5, 100.0)])
    last = abs(Sensors().current(source.parts[0])[-1])
    assert PLATE.i_limit < last < 1.2 * PLATE.i_limit


def test_the_current_follows_its_reference_as_the_bandwidth_says() -> None:
    """A step of 1 A along the d axis, after one delay of 1.5 periods: 1 - exp(-t / T)."""
    ideal = dataclasses.replace(MOTOR, adc_bits=24, u_transistor=0.0, u_diode=0.0)
    s = Scenarios.nominal(ideal, np.array([1], np.uint64), 1.0)
    s.noise[:] = s.dead_time[:] = 0.0
    source, bandwidth = Simulated(ideal, s), 0.02 / PLATE.T_s
    gains = Gains(MOTOR.R_s, MOTOR.L_d, bandwidth)
    part = source.run("start", [amps(300 * PLATE.T_s, 1.0, 0.0)], gains)
    i = Sensors().current(part).real
    time = (np.arange(len(i)) - 1.5) * PLATE.T_s
    assert i == pytest.approx(np.clip(1.0 - np.exp(-bandwidth * time), 0.0, 1.0), abs=0.02)


def test_the_joint_fit_decides_on_inertia_and_iron(
    measured: tuple[Simulated, Identified], monkeypatch: pytest.MonkeyPatch
) -> None:
    """1 / J is 1.25 times that of the spin, known to 2 %; the iron conducts 1 mS."""
    spins: list[Spin] = []
    fits: list[tuple[Any, Joint]] = []

    def spun(*given: Any) -> Spin:
        spins.append(measure_spin(*given))
        return spins[-1]

    def fitted(*given: Any) -> Joint:
        joint = dataclasses.replace(fit_jointly(*given), share=1.25, doubt=0.02, g=1e-3)
        fits.append((given, joint))
        return joint

    monkeypatch.setattr(procedure, "measure_spin", spun)
    monkeypatch.setattr(procedure, "fit_jointly", fitted)
    found = identify_machine(Recorded(measured[0].parts), PLATE)
    (spin,), first = spins, spins[0].mechanics
    _, _, _, turn, doubt, _ = fits[0][0]
    assert turn == pytest.approx(1.5 * PLATE.n_p**2 / first.J)
    assert doubt == pytest.approx(first.J_std / first.J)
    assert found.spin.mechanics.J == pytest.approx(first.J / 1.25)
    assert found.spin.mechanics.J_std == pytest.approx(0.02 * first.J / 1.25)
    curves = fit_curves(fits[-1][1].samples, PLATE.i_rated)
    assert found.spin.psi_f == pytest.approx(spin.again(curves, 1e-3).psi_f, rel=1e-9)
    assert spin.again(curves).psi_f != pytest.approx(found.spin.psi_f, rel=1e-6)


@pytest.mark.parametrize("error", [ZeroDivisionError, ValueError, IndexError, FloatingPointError])
def test_whatever_readings_break_is_a_user_error(
    error: type[Exception], monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> None:
        raise error("odd")

    monkeypatch.setattr(procedure, "measure_offsets", broken)
    with pytest.raises(UserError, match="fit no machine \\(odd\\)"):
        identify_machine(Recorded([]), PLATE)
