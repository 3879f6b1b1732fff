"""The whole procedure on the simulated drive, and once more from what it measured."""

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.envs.scenarios.machine_family import member
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.errors import UserError
from sensorless.identify.machine.electric import Sensors
from sensorless.identify.machine.hold import measure_offsets, measure_resistance
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.procedure import Identified, identify_machine
from sensorless.identify.machine.result import doubts, motor_tables
from sensorless.identify.machine.simulated import Simulated, real_drive
from sensorless.identify.machine.source import Recorded
from sensorless.machine import motor_file
from sensorless.machine.motor import Motor

MOTOR = Motor.load("ipmsm_2200w")


def test_a_drive_with_errors_finds_its_machine(measured: tuple[Simulated, Identified]) -> None:
    gain = float(np.sqrt(np.prod(real_drive(MOTOR, 3).gain[0])))
    found = Motor.from_tables(motor_tables(measured[1]), "identified")
    assert found.R_s * gain == pytest.approx(MOTOR.R_s, rel=0.003)
    assert found.L_q * gain == pytest.approx(MOTOR.L_q, rel=0.03)
    assert found.L_d * gain == pytest.approx(MOTOR.L_d, rel=0.03)
    assert found.psi_f == pytest.approx(MOTOR.psi_f, rel=0.01)
    assert found.J == pytest.approx(MOTOR.J, rel=0.05)
    assert found.u_dc == MOTOR.u_dc and found.n_p == MOTOR.n_p


def test_voltages_of_another_scale_do_not_fit_the_name_plate(
    measured: tuple[Simulated, Identified],
) -> None:
    data = motor_tables(measured[1])
    assert doubts(data) == []
    for scale, word in ((1.73, "1.9 times tau_rated"), (0.58, "rated torque 14 N m needs")):
        machine = {k: v * scale for k, v in data["machine"].items() if k not in ("n_p", "B")}
        scaled = data["machine"] | machine
        odd = {k: v for k, v in data.items() if k != "saturation"} | {"machine": scaled}
        assert any(word in text for text in doubts(odd))


def test_an_exact_drive_finds_its_machine_exactly() -> None:
    ideal = dataclasses.replace(MOTOR, adc_bits=24, u_transistor=0.0, u_diode=0.0)
    s = Scenarios.nominal(ideal, np.array([1], np.uint64), 1.0)
    s.noise[:] = s.dead_time[:] = 0.0
    found = identify_machine(Simulated(ideal, s), Nameplate.of(ideal))
    assert found.resistance.R_s == pytest.approx(MOTOR.R_s, rel=1e-4)
    assert found.spin.psi_f == pytest.approx(MOTOR.psi_f, rel=1e-3)
    assert found.spin.mechanics.J == pytest.approx(MOTOR.J, rel=0.01)
    assert 1.0 / found.map_fit.saturation.a_d0 == pytest.approx(MOTOR.L_d, rel=2e-3)
    assert 1.0 / found.map_fit.saturation.a_q0 == pytest.approx(MOTOR.L_q, rel=2e-3)


def test_a_voltage_that_runs_ahead_of_a_slow_current_is_lowered() -> None:
    """The ramp's first voltage with a current ends up driving more than rated current."""
    slow = member(606, 21)
    drive = real_drive(slow, 606 + 21)
    source, plate = Simulated(slow, drive), Nameplate.of(slow)
    found = measure_resistance(source, plate, measure_offsets(source))
    assert found.R_s * np.sqrt(np.prod(drive.gain[0])) == pytest.approx(slow.R_s, rel=0.003)
    assert found.i.max() < 1.05 * plate.i_rated
    assert len(np.unique(np.round(np.abs(found.u), 3))) == 7
    ramp = [Sensors().current(part).real for part in source.parts if part.stage == "ramp"]
    assert max(i.max() for i in ramp) < 1.02 * plate.i_rated


def test_the_log_and_the_name_plate_alone_give_the_same_machine(
    measured: tuple[Simulated, Identified],
) -> None:
    unknown = dataclasses.replace(MOTOR, R_s=1.0, L_d=0.1, L_q=0.2, psi_f=9.0, J=1.0, B=1.0)
    assert Nameplate.of(unknown) == Nameplate.of(MOTOR)
    again = identify_machine(Recorded(measured[0].parts), Nameplate.of(unknown))
    assert motor_tables(again) == motor_tables(measured[1])


def test_a_shaft_that_does_not_turn_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    stuck = dataclasses.replace(MOTOR, J=1e9)
    with pytest.raises(UserError, match=r"spin|rotor"):
        identify_machine(Simulated(stuck, real_drive(stuck, 3)), Nameplate.of(stuck))


def test_a_wrong_current_on_the_name_plate_is_refused() -> None:
    plate = dataclasses.replace(Nameplate.of(MOTOR), i_rated=2.0 * MOTOR.adc_range)
    with pytest.raises(UserError, match="current"):
        identify_machine(Simulated(MOTOR, real_drive(MOTOR, 3)), plate)


@pytest.mark.parametrize("words", [("machine",), ("bring-up", "--mistake", "right")])
def test_a_file_that_contradicts_itself_is_refused(words: tuple[str, ...], tmp_path: Path) -> None:
    shipped = Path(motor_file.__file__).with_name("motors") / "ipmsm_2200w.toml"
    text, n = re.subn(r"n_rated_rpm = [\d.]+", "n_rated_rpm = 0.5", shipped.read_text("utf-8"))
    (tmp_path / "slow.toml").write_text(text, "utf-8")
    done = CliRunner().invoke(app, ["identify", *words, "--motor", str(tmp_path / "slow.toml")])
    assert n == 1 and isinstance(done.exception, UserError)
    assert "n_rated_rpm = 0.5" in str(done.exception)


def test_the_command_shows_every_quantity() -> None:
    done = CliRunner().invoke(app, ["identify", "machine", "--motor", "ipmsm_2200w"])
    assert done.exit_code == 0, done.output
    for word in ("R_s", "lost voltage", "L_d", "L_q", "psi_f", "saturation", "linear"):
        assert word in done.output
