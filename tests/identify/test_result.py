"""The motor file and the rows of an identification whose numbers are set here."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.errors import UserError
from sensorless.identify.machine.procedure import Identified
from sensorless.identify.machine.result import motor_tables, screen
from sensorless.identify.machine.simulated import Simulated
from sensorless.machine.motor import Motor, Saturation

Measured = tuple[Simulated, Identified]


def with_map(found: Identified, s: Saturation) -> Identified:
    return replace(found, map_fit=replace(found.map_fit, saturation=s))


@pytest.mark.parametrize(("ratio", "fit"), [(1.04, False), (1.06, True)])
def test_a_machine_without_saliency_is_refused(ratio: float, fit: bool, measured: Measured) -> None:
    found = with_map(measured[1], Saturation.linear(0.04, ratio * 0.04, 0.5))
    if fit:
        machine = motor_tables(found)["machine"]
        assert machine["L_q"] == pytest.approx(ratio * 0.04, rel=1e-5)
        return
    with pytest.raises(UserError, match="without saliency"):
        motor_tables(found)


def test_no_friction_below_zero(measured: Measured) -> None:
    spin = measured[1].spin
    found = replace(measured[1], spin=replace(spin, mechanics=replace(spin.mechanics, B=-1e-3)))
    assert motor_tables(found)["machine"]["B"] == 0.0


def test_the_map_has_six_digits(measured: Measured) -> None:
    model = replace(Motor.load("paper").saturation, a_q0=1.85916914)
    assert motor_tables(with_map(measured[1], model))["saturation"]["a_q0"] == 1.85917


def test_the_rows_on_the_screen(measured: Measured) -> None:
    """0.01 of 2 ohm is 0.5 %; the terms are those of the paper's motor."""
    error = np.array([0.02, 0.05]) * measured[1].plate.i_rated
    fit = measured[1].map_fit
    fit = replace(fit, error=np.broadcast_to(error, fit.error.shape))
    found = with_map(replace(measured[1], map_fit=fit), Motor.load("paper").saturation)
    found = replace(
        found,
        resistance=replace(found.resistance, R_s=2.0, R_std=0.01),
        samples=replace(found.samples, left=0.021),
    )
    rows = {name: (value, share, how) for name, value, share, how in screen(found)}
    assert rows["R_s"][:2] == ("2 ohm", "0.5 %")
    assert rows["saturation"][0] == "d^4, q^1, cross 0,0"
    assert (rows["L_d"][1], rows["L_q"][1]) == ("2.00 % of rated", "5.00 % of rated")
    assert "2.1 % left over" in rows["L_d"][2]
    linear = with_map(found, Saturation.linear(0.04, 0.08, 0.5))
    assert {row[0]: row[1] for row in screen(linear)}["saturation"] == "linear"
