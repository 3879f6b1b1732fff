"""The fits of a load sweep: line and table, on angles that are known."""

import numpy as np
import pytest

from sensorless.identify.cross_coupling import fit_line, fit_table, lookup

NODES = np.arange(6.0)


def test_a_table_is_found_again_and_goes_on_in_a_straight_line() -> None:
    """Odd, with 0.1, 0.3, 0.2 rad at 1, 2, 3 A; measured up to 2.9 A."""
    i_q = np.linspace(-2.9, 2.9, 40)
    angle = np.sign(i_q) * np.interp(np.abs(i_q), NODES[:4], [0.0, 0.1, 0.3, 0.2])
    found = fit_table(NODES, i_q, angle)
    assert found == pytest.approx(np.array([0.0, 0.1, 0.3, 0.2, 0.1, 0.0]), abs=1e-12)
    assert lookup(NODES, found, np.array([-1.5, 0.0, 2.5])) == pytest.approx([-0.2, 0.0, 0.25])


def test_a_node_that_few_currents_reach_is_not_fitted() -> None:
    """From 2.4 A the node at 3 A would be a guess from a far corner; the line goes on."""
    i_q = np.linspace(-2.4, 2.4, 49)
    angle = np.where(np.abs(i_q) > 2.05, 9.0, 0.1 * np.abs(i_q)) * np.sign(i_q)
    assert fit_table(NODES, i_q, angle) == pytest.approx(0.1 * NODES, abs=1e-12)


def test_a_line_over_both_directions_and_over_each() -> None:
    """0.1 rad/A forward, 0.2 backward: 0.15 in common, off by 0.05 a working ampere."""
    i_q = np.array([-6.0, -4.0, -2.0, -1.0, 1.0, 2.0, 4.0, 6.0])
    angle = np.array([-3.0, -0.8, -0.4, -0.2, 0.1, 0.2, 0.4, 3.0])
    line = fit_line(i_q, angle, np.abs(i_q) <= 2.0, 4.0)
    assert line.slope == pytest.approx(0.15) and line.slopes == pytest.approx((0.1, 0.2))
    assert line.up_to == 2.0
    assert line.fit.residual_max_deg == pytest.approx(np.degrees(0.1))
    assert line.fit.residual_rms_deg == pytest.approx(np.degrees(np.sqrt(0.00625)))
    assert line.to_rated.residual_max_deg == pytest.approx(np.degrees(0.2))
    # about their mean of -0.075 rad the working angles have a square of 0.2275; left is 0.025
    assert line.fit.r2 == pytest.approx(1.0 - 0.025 / 0.2275)
    assert line.fits[0].residual_max_deg == pytest.approx(np.degrees(0.1))
