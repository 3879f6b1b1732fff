"""Cross-coupling of the injection estimator in the loop. Angles: estimate minus truth."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.errors import UserError
from sensorless.evaluation.steady import make_ideal, steady
from sensorless.identify.cross_coupling import (
    CrossCoupling,
    fit_table,
    identify_cross_coupling,
    lookup,
)
from sensorless.machine.magnetics import cross_angle
from sensorless.machine.motor import Motor

AT_ZERO = DriveDesign(estimator="smo", mtpa=False, cross="none")
RPM = [150.0, 150.0, -150.0, -150.0]
TAU = [6.0, -6.0, 6.0, -6.0]


@pytest.fixture(scope="module")
def found(motor: Motor) -> CrossCoupling:
    return identify_cross_coupling(motor, AT_ZERO)


def test_raw_error_in_four_quadrants(motor: Motor) -> None:
    """7.7 degrees at 150 r/min, 6 N m, id = 0, with the sign of the torque, not of the speed."""
    run = steady(motor, AT_ZERO, RPM, TAU, 1.0, change=make_ideal)
    assert run.held.all()
    assert np.rad2deg(-run.err) == pytest.approx(7.7 * np.sign(TAU), abs=0.3)


@pytest.mark.parametrize("mtpa", [False, True])
@pytest.mark.parametrize("cross", ["line", "table"])
def test_compensated_error(motor: Motor, mtpa: bool, cross: str) -> None:
    """Mean below half a degree in all quadrants, with real sensors."""
    design = replace(AT_ZERO, cross=cross, mtpa=mtpa)
    run = steady(motor, design, RPM, TAU, 1.0, window=1.0)
    assert run.held.all()
    assert np.all(np.abs(np.rad2deg(run.err)) < 0.5)


def test_sweep_meets_the_flux_map(motor: Motor, found: CrossCoupling) -> None:
    """What an encoder sees is Eq. 16 at the currents that flow."""
    np.testing.assert_allclose(
        np.rad2deg(found.angle), np.rad2deg(cross_angle(motor, found.i)), atol=0.6
    )
    assert found.i[:, 1].min() < -0.8 * motor.i_rated
    assert found.i[:, 1].max() > 0.8 * motor.i_rated


def test_line_and_table(found: CrossCoupling) -> None:
    """A line is good to half a degree up to half of rated torque, in both directions.

    At rated current, where the q axis is saturated, it is far off; the table leaves noise.
    """
    line = found.line
    assert np.rad2deg(line.slope) == pytest.approx(-3.96, abs=0.15)
    assert np.rad2deg(line.slopes) == pytest.approx([np.rad2deg(line.slope)] * 2, abs=0.1)
    assert line.fit.r2 > 0.996
    assert max(fit.residual_max_deg for fit in line.fits) < 0.6
    assert line.to_rated.residual_max_deg > 3.0
    assert np.all(np.abs(np.rad2deg(found.left_line)) < 0.6)
    assert found.table_fit.residual_max_deg < 0.6
    assert np.all(np.abs(np.rad2deg(found.left)) < 0.6)


def test_an_identified_file_runs_the_drive(
    motor: Motor, found: CrossCoupling, tmp_path: Path
) -> None:
    """What identify writes compensates the drive it was made for, and no other machine."""
    path = tmp_path / "cc.json"
    found.write(path)
    design = replace(AT_ZERO, cross=str(path))
    assert np.all(np.abs(np.rad2deg(steady(motor, design, RPM, TAU, 1.0).err)) < 0.5)
    with pytest.raises(UserError, match="measured on machine 'paper', not on"):
        control_record(replace(motor, R_s=2.0), design)
    path.write_text(re.sub(r'("angle_deg": \[\s*)[^,]*', r"\g<1>1e9", path.read_text()))
    with pytest.raises(UserError, match="within 90 degrees"):
        control_record(motor, design)
    path.write_text('{"format": "sensorless-cross-coupling/1"}')
    with pytest.raises(UserError, match="measured on machine None, not on"):
        control_record(motor, design)
    path.write_text("{")
    with pytest.raises(UserError, match="give a file that sensorless identify"):
        control_record(motor, design)
    with pytest.raises(UserError, match="No such file"):
        control_record(motor, replace(design, cross="no/such.json"))


def test_table_fit_is_exact_where_it_can_be() -> None:
    """An odd, piecewise linear function is found back, and runs on straight beyond the data."""
    nodes = np.linspace(0.0, 8.0, 9)
    true = np.array([0.0, -1.0, -1.5, -3.0, -3.5, -4.0, -4.5, -5.0, -5.5])
    i_q = np.linspace(-5.0, 5.0, 60)
    np.testing.assert_allclose(fit_table(nodes, i_q, lookup(nodes, true, i_q)), true, atol=1e-12)
