"""What a start can tell of the poles, at rest and on a spinning shaft."""

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.magnetics import Floats, currents
from sensorless.machine.motor import MOTORS, Motor
from sensorless.observers import start_design
from sensorless.observers.start_design import (
    knows_poles,
    polarity_pulse,
    pole_difference,
    spin_speed,
)


@pytest.mark.parametrize(("times", "counts"), [(0.5, 0.5), (2.0, 1.0), (-1.0, 0.0)])
def test_the_lesser_of_model_and_map_tells_the_poles(
    times: float, counts: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A map whose pulses differ by less, by more, and the other way round."""
    motor = Motor.load("paper")
    _, by_model = polarity_pulse(motor)

    def of_map(motor: Motor, psi: Floats) -> Floats:
        return times * currents(motor.saturation, psi)

    monkeypatch.setattr(start_design, "plant_currents", of_map)
    assert pole_difference(motor) == pytest.approx(counts * by_model)


def test_a_shaft_is_found_from_a_quarter_above_the_speed_that_shows_the_pole() -> None:
    """What is left of the EMF's noise and of the speed's error has that room."""
    motor = Motor.load("paper")
    start = control_record(motor, DriveDesign())["start"]
    shows = float(start["omega_pole"]) / motor.n_p * 30.0 / np.pi
    assert spin_speed(motor) == pytest.approx(1.25 * shows, rel=1e-5)


def test_a_pulse_stays_within_the_voltage_of_the_link() -> None:
    """And has its volt-seconds in as few whole periods as 0.8 of that allows, two at least."""
    motors = [m for m in map(Motor.load, sorted(MOTORS.glob("*.toml"))) if knows_poles(m)]
    assert motors
    for motor in motors:
        start = control_record(motor, DriveDesign())["start"]
        u, n = float(start["u_pulse"]), int(start["n_pulse"])
        most = 0.8 * motor.u_dc / np.sqrt(3.0)
        assert u * n * motor.T_s == pytest.approx(polarity_pulse(motor)[0], rel=1e-5)
        assert 0.0 < u <= most and (n == 2 or u * n / (n - 1) > most)
