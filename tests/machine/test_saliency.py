"""Saliency: refused where there is none, and read off the flux map."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.errors import UserError
from sensorless.machine.magnetics import cross_angle, mtpa
from sensorless.machine.motor import Motor, Saturation
from sensorless.machine.saliency import principal


def linear(L_d: float, L_q: float) -> Motor:
    motor = Motor.load("ipmsm_2200w")
    return replace(motor, L_d=L_d, L_q=L_q, saturation=Saturation.linear(L_d, L_q, motor.psi_f))


@pytest.mark.parametrize("L_q", [0.036, 0.0365, 0.0355])
def test_no_saliency_is_refused_by_the_design(L_q: float) -> None:
    """Surface magnets, or what two per cent of tolerance may make of it."""
    with pytest.raises(UserError, match="without saliency") as error:
        control_record(linear(0.036, L_q), DriveDesign())
    assert "L_d = 0.036 H" in str(error.value)
    assert f"L_q = {L_q:g} H" in str(error.value)


def test_swapped_axes_are_named() -> None:
    with pytest.raises(UserError, match="swap the two"):
        control_record(linear(0.051, 0.036), DriveDesign())


@pytest.mark.parametrize(("L_q", "said"), [(0.036, "without saliency"), (0.03, "swap the two")])
def test_a_map_without_saliency_is_refused(L_q: float, said: str) -> None:
    """The drive runs on [saturation], whatever L_d and L_q of the file are."""
    motor = linear(0.036, 0.051)
    flat = replace(motor, saturation=Saturation.linear(0.036, L_q, motor.psi_f))
    with pytest.raises(UserError, match=rf"\[saturation\] .* L_q = {L_q:g} H.*{said}"):
        control_record(flat, DriveDesign())


def test_linear_machine_has_its_inductances_at_every_current() -> None:
    motor = linear(0.036, 0.051)
    i = mtpa(motor)
    assert principal(motor, i) == pytest.approx(np.tile([0.036, 0.051], (len(i), 1)), rel=1e-6)


def test_saturated_machine_against_the_closed_form() -> None:
    """Rated current on the q axis: L_d .0655, L_q .1605, L_dq -.0312, derived independently."""
    motor = Motor.load("paper")
    i = np.array([[0.0, 0.0], [0.0, 5.63]])
    found = principal(motor, i)
    assert found[0] == pytest.approx([0.063, 0.286], rel=1e-4)
    assert found[1] == pytest.approx(
        np.linalg.eigvalsh([[0.0655, -0.0312], [-0.0312, 0.1605]]), rel=0.005
    )
    assert np.rad2deg(cross_angle(motor, i[1:]))[0] == pytest.approx(-16.6, abs=0.1)
