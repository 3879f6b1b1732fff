"""Machines that cannot be are refused by field and value; every shipped or random one passes."""

import dataclasses
from typing import Any

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.machine_family import family
from sensorless.errors import UserError
from sensorless.machine.motor import MOTORS, Motor, Saturation
from sensorless.machine.sane import insane, require_sane

MOTOR = Motor.load("pmsyrm_5600w")


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [("B", 1e12, "friction of"), ("B", 1.0, "or 0"), ("R_s", 630.0, "in ohm, of one phase")],
)
def test_a_number_no_machine_has_is_named(field: str, value: float, said: str) -> None:
    change: dict[str, Any] = {field: value}
    broken = dataclasses.replace(MOTOR, **change)
    with pytest.raises(UserError, match=f"{field} = {value:g}".replace("+", r"\+")) as error:
        control_record(broken, DriveDesign())
    assert said in str(error.value)


@pytest.mark.parametrize("share", [0.95, 1.05])
def test_friction_above_rated_torque_and_a_drop_above_the_link_are_refused(share: float) -> None:
    """A machine just below either is unusual, and none of this check's business."""
    speed = MOTOR.omega_rated / MOTOR.n_p
    changes: list[dict[str, Any]] = [
        {"B": share * MOTOR.tau_rated / speed},
        {"R_s": share * MOTOR.u_dc / MOTOR.i_rated},
    ]
    for change in changes:
        refused = [field for field, _ in insane(dataclasses.replace(MOTOR, **change))]
        assert refused == (list(change) if share > 1.0 else [])


@pytest.mark.parametrize(("field", "value"), [("L_d", 3.6e-11), ("psi_f", 5.45e8)])
def test_a_magnet_that_no_current_cancels_is_named(field: str, value: float) -> None:
    change: dict[str, Any] = {field: value}
    broken = dataclasses.replace(Motor.load("ipmsm_2200w"), **change)
    s = Saturation.linear(broken.L_d, broken.L_q, broken.psi_f)
    with pytest.raises(UserError, match=f"{field} = {value:g}".replace("+", r"\+")):
        control_record(dataclasses.replace(broken, saturation=s), DriveDesign())


@pytest.mark.parametrize(("share", "refused"), [(0.9, []), (1.1, ["L_d"])])
def test_a_magnet_of_ten_thousand_rated_currents_is_refused(
    share: float, refused: list[str]
) -> None:
    motor = Motor.load("ipmsm_2200w")
    psi_f = share * 1e4 * motor.L_d * motor.i_rated
    s = Saturation.linear(motor.L_d, motor.L_q, psi_f)
    strong = dataclasses.replace(motor, psi_f=psi_f, saturation=s)
    assert [field for field, _ in insane(strong)] == refused


@pytest.mark.parametrize(
    ("name", "value"), [("a_dd", 1e12), ("a_q0", 1e7), ("a_dq", 1e12), ("i_f", 1e9), ("a_b", 1e9)]
)
def test_the_term_that_spoils_a_map_is_named(name: str, value: float) -> None:
    change: dict[str, Any] = {name: value}
    spoilt = dataclasses.replace(MOTOR.saturation, **change)
    with pytest.raises(UserError, match=rf"{name} = .* gives .* remove \[saturation\]"):
        require_sane(dataclasses.replace(MOTOR, saturation=spoilt))


def test_machines_pass() -> None:
    for motor in (*map(Motor.load, MOTORS.glob("*.toml")), *family(1, 32)):
        require_sane(motor)
