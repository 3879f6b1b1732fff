"""Lock offset of the injection estimator in the closed loop, by its two details of timing."""

import pytest

from sensorless.machine.motor import Motor
from sensorless.reproduce.printed import lock_offsets


@pytest.mark.parametrize(
    ("scheme", "delay_cure", "offsets"),
    [
        ("rotating", True, [0.0, 0.0, 0.0, -0.001]),
        ("rotating", False, [-0.15, -0.36, -0.61, -1.54]),
        ("stationary", True, [-0.23, -0.54, -0.92, -2.31]),
        ("stationary", False, [-0.38, -0.90, -1.54, -3.86]),
    ],
)
def test_lock_offsets(motor: Motor, scheme: str, delay_cure: bool, offsets: list[float]) -> None:
    """Estimate minus truth [deg] at 150, 350, 600 and 1500 r/min, from the exact discrete model."""
    assert lock_offsets(motor, scheme, delay_cure) == pytest.approx(offsets, abs=0.05)
