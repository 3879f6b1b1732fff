"""Duty cycles and losses of three legs, against numbers worked out by hand."""

import numpy as np
import pytest

from sensorless.machine.phases import duties, leg_losses


@pytest.mark.parametrize(
    ("u", "wanted"),
    [
        ((0.0, 0.0), (0.5, 0.5, 0.5)),
        ((200.0, 0.0), (0.75, 0.25, 0.25)),  # legs want 200, -100, -100 V, less their middle 50
        ((-200.0, 0.0), (0.25, 0.75, 0.75)),
        ((0.0, 100.0 * np.sqrt(3.0)), (0.5, 0.75, 0.25)),  # 0, 150, -150 V
        ((600.0, 0.0), (1.0, 0.0, 0.0)),  # beyond the link: 450 V over 600 V is cut
    ],
)
def test_duty_cycles_lie_alike_about_a_half(
    u: tuple[float, float], wanted: tuple[float, float, float]
) -> None:
    found = duties(np.array([u]), np.array([600.0]))
    assert found[0] == pytest.approx(wanted, abs=1e-12)


def test_a_leg_loses_in_proportion_up_to_a_current_and_no_more_beyond() -> None:
    found = leg_losses(np.array([[0.05, -0.2, 5.0], [-0.2, 0.1, -5.0]]), 6.0, 5.0)
    assert found == pytest.approx(np.array([[1.5, -6.0, 6.0], [-6.0, 3.0, -6.0]]))
