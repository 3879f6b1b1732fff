"""A flux map beside the motor file that it extends."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.machine.mapped import far_from, outside
from sensorless.machine.motor import Motor


@pytest.mark.parametrize(
    ("change", "names"),
    [
        ({}, []),
        ({"L_d": 1.2, "L_q": 0.8}, []),
        ({"L_d": 2.0**0.5, "L_q": 2.0**0.5}, ["L_d is 1.41", "L_q is 1.41"]),
        ({"psi_f": 0.577}, ["psi_f is 0.58"]),
    ],
)
def test_what_is_far_from_the_motor_file_is_named(
    motor: Motor, change: dict[str, float], names: list[str]
) -> None:
    """Currents in RMS, and an EMF from line to line over root 3 twice."""
    made = replace(motor, **{name: x * getattr(motor, name) for name, x in change.items()})
    said = far_from(made, motor)
    assert len(said) == len(names)
    assert all(line.startswith(name) for line, name in zip(said, names, strict=True))


@pytest.mark.parametrize(
    ("low", "top", "said"), [(-1.1, 1.1, ""), (0.0, 1.1, "i_d from"), (-1.1, 0.3, "i_q up to")]
)
def test_a_map_without_the_operating_points_is_named(low: float, top: float, said: str) -> None:
    motor = Motor.load("paper")
    d, q = np.meshgrid(np.linspace(low, 0.2, 9), np.linspace(-top, top, 9))
    found = outside(motor, motor.i_rated * np.stack([d.ravel(), q.ravel()], axis=-1))
    assert len(found) == (said != "")
    assert all(said in text and "the drive runs at" in text for text in found)
