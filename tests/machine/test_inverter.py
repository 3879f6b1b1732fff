"""What the switches of an inverter take where the motor file does not say it."""

from dataclasses import replace

import pytest

from sensorless.machine.inverter import threshold_voltage
from sensorless.machine.motor import Motor

PAPER = Motor.load("paper")


@pytest.mark.parametrize(("u_dc", "volt"), [(150.0, 0.875), (149.0, 0.0)])
def test_a_link_from_150_v_on_has_transistors_with_a_threshold(u_dc: float, volt: float) -> None:
    """Half of an IGBT's 0.7 to 1.2 V and half of its diode's 0.6 to 1 V; MOSFETs have none."""
    assert threshold_voltage(replace(PAPER, u_dc=u_dc)) == pytest.approx(volt)


def test_one_threshold_of_the_file_stands_for_itself() -> None:
    """A file with one of the two says that the other is zero."""
    assert threshold_voltage(replace(PAPER, u_transistor=1.0)) == pytest.approx(0.5)
    assert threshold_voltage(replace(PAPER, u_diode=0.8)) == pytest.approx(0.4)
