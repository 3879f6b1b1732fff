"""Numbers of a motor file against each other: per-unit values, and how much each slip weighs."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from sensorless.machine.motor import Motor, Saturation
from sensorless.suitability.finding import LIMIT, NO, NOTE, Finding
from sensorless.suitability.plausible import plausible

MOTOR = Motor.load("ipmsm_2200w")
PAPER = Motor.load("paper")
U = MOTOR.u_dc / math.sqrt(3.0)  # largest voltage of a phase
W_M = MOTOR.n_rated_rpm * math.pi / 30.0
W = MOTOR.n_p * W_M


def findings(field: str, motor: Motor = MOTOR, **changes: Any) -> list[Finding]:
    """What is found about a field; a linear machine stays one."""
    out = replace(motor, **changes)
    if motor is MOTOR:
        out = replace(out, saturation=Saturation.linear(out.L_d, out.L_q, out.psi_f))
    return [f for f in plausible(out) if f.field == field]


def implausible(field: str, **changes: Any) -> Finding:
    """The one objection to a field; a note is none."""
    (found,) = (f for f in findings(field, **changes) if f.weight != NOTE)
    return found


def weights(field: str, motor: Motor = MOTOR, **changes: Any) -> list[str]:
    return [f.weight for f in findings(field, motor, **changes)]


def most_torque() -> float:
    """Magnet's torque and reluctance's, each the largest over all angles of rated current."""
    angle = np.linspace(0.0, 0.5 * math.pi, 1001)
    i_d, i_q = -MOTOR.i_rated * np.sin(angle), MOTOR.i_rated * np.cos(angle)
    iron = (MOTOR.L_d - MOTOR.L_q) * i_d * i_q
    return float(1.5 * MOTOR.n_p * (np.max(MOTOR.psi_f * i_q) + np.max(iron)))


@pytest.mark.parametrize(
    ("field", "changes", "value"),
    [
        ("psi_f", {"psi_f": 3.0}, W * 3.0 / U),
        ("R_s", {"R_s": 60.0}, 60.0 * MOTOR.i_rated / U),
        ("L_d", {"L_d": 0.3, "L_q": 0.4}, W * 0.3 * MOTOR.i_rated / U),
        ("L_q", {"L_q": 0.8}, W * 0.8 * MOTOR.i_rated / U),
        ("tau_rated", {"tau_rated": 60.0}, 60.0 / most_torque()),
        ("J", {"J": 3.0}, 3.0 * W_M / MOTOR.tau_rated),
    ],
)
def test_the_share_that_is_told_is_that_of_the_machine(
    field: str, changes: dict[str, float], value: float
) -> None:
    """Voltages over the link's largest, torque over the most that the current can make, seconds."""
    told = float(implausible(field, **changes).text.split(" is ")[1].split(",")[0])
    assert told == pytest.approx(value, rel=5e-3)


@pytest.mark.parametrize("field", ["psi_f", "R_s", "L_q", "tau_rated"])
def test_three_times_beyond_the_usual_is_an_error(field: str) -> None:
    """Less is an unusual machine: it is limited, and not refused."""
    far = implausible(field, **{field: 100.0 * getattr(MOTOR, field)}).text
    value, end = far.split(" is ")[1].split(",")[0], far.split(" to ")[-1].split(":")[0]
    usual = 100.0 * getattr(MOTOR, field) * float(end) / float(value)  # the largest
    assert implausible(field, **{field: 2.5 * usual}).weight == LIMIT
    assert implausible(field, **{field: 3.5 * usual}).weight == NO


@pytest.mark.parametrize(
    ("share", "weight"), [(0.09, None), (0.13, LIMIT), (0.45, LIMIT), (0.6, NO)]
)
def test_a_dead_time_of_half_a_period_leaves_no_voltage(share: float, weight: str | None) -> None:
    """A leg switches twice in a period and waits each time."""
    found = weights("dead_time", dead_time=share * MOTOR.T_s)
    assert found == ([weight] if weight else [])


@pytest.mark.parametrize(("periods", "weight"), [(21, None), (19, LIMIT), (9, LIMIT), (7, NO)])
def test_few_periods_a_turn_limit_and_too_few_refuse(periods: int, weight: str | None) -> None:
    turns = 1.0 / (periods * MOTOR.T_s)  # electrical, in a second
    found = weights("T_s", n_rated_rpm=60.0 * turns / MOTOR.n_p)
    assert found == ([weight] if weight else [])


@pytest.mark.parametrize(
    ("factor", "weight"),
    [(1.04, None), (1.08, LIMIT), (2.4, LIMIT), (2.6, NO), (1 / 1.08, LIMIT), (1 / 2.6, NO)],
)
def test_a_flux_map_may_differ_by_rounding_only(factor: float, weight: str | None) -> None:
    """More is a limit, and beyond a factor of 2.5 either way it is another machine."""
    found = findings("psi_f", PAPER, psi_f=factor * PAPER.psi_f)
    found = [f for f in found if f.text.startswith("[saturation]")]
    assert [f.weight for f in found] == ([weight] if weight else [])


@pytest.mark.parametrize(("share", "noted"), [(0.19, False), (0.21, True)])
def test_resistance_that_takes_a_fifth_of_the_emf_is_noted(share: float, noted: bool) -> None:
    R_s = share * W * MOTOR.psi_f / MOTOR.i_rated
    assert weights("R_s", R_s=R_s) == ([NOTE] if noted else [])


@pytest.mark.parametrize(("share", "weight"), [(1.01, None), (0.2, LIMIT), (0.09, NO)])
def test_a_current_limit_of_a_tenth_turns_no_shaft(share: float, weight: str | None) -> None:
    assert weights("i_max", i_max=share * MOTOR.i_rated) == ([weight] if weight else [])


@pytest.mark.parametrize(("share", "weight"), [(0.19, None), (0.57, LIMIT), (0.58, NO)])
def test_injection_beyond_what_the_link_gives_is_refused(share: float, weight: str | None) -> None:
    """The largest phase voltage is 1 / sqrt(3) = 0.577 of the link; a fifth of it is the limit."""
    assert weights("u_inj", u_inj=share * MOTOR.u_dc) == ([weight] if weight else [])


@pytest.mark.parametrize(("share", "noted"), [(0.99, False), (1.01, True)])
def test_a_trip_that_the_converter_cannot_see_is_noted(share: float, noted: bool) -> None:
    i_trip = share * MOTOR.adc_range
    told = [f.weight for f in findings("i_trip", i_trip=i_trip) if "in hardware" in f.text]
    assert told == ([NOTE] if noted else [])
