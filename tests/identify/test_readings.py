"""A log whose currents do not answer its voltages is told so, with what is wrong."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.errors import UserError
from sensorless.identify.machine.log import NUMBERS, Part, write_log
from sensorless.identify.machine.procedure import Identified
from sensorless.identify.machine.readings import require_answers
from sensorless.identify.machine.simulated import Simulated
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor

MOTOR = Motor.load("ipmsm_2200w")
Wrong = Callable[[Floats], None]
U_ALPHA, U_BETA, I_A, I_B = (NUMBERS.index(name) for name in ("u_alpha", "u_beta", "i_a", "i_b"))


def turned(*columns: int) -> Wrong:
    def change(rows: Floats) -> None:
        rows[:, columns] *= -1.0

    return change


def swapped(a: int, b: int) -> Wrong:
    def change(rows: Floats) -> None:
        rows[:, [a, b]] = rows[:, [b, a]]

    return change


def moved(by: int) -> Wrong:
    def change(rows: Floats) -> None:
        rows[:, [U_ALPHA, U_BETA]] = np.roll(rows[:, [U_ALPHA, U_BETA]], by, axis=0)

    return change


def scaled(column: int, gain: float) -> Wrong:
    def change(rows: Floats) -> None:
        rows[:, column] *= gain

    return change


def phases_b_and_c(rows: Floats) -> None:
    rows[:, I_B] = -rows[:, I_A] - rows[:, I_B]


def phases_a_and_c(rows: Floats) -> None:
    rows[:, I_A] = -rows[:, I_A] - rows[:, I_B]


def spoilt(parts: list[Part], change: Wrong) -> list[Part]:
    out = [Part(p.stage, p.rows.copy()) for p in parts]
    for part in out:
        change(part.rows)
    return out


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (turned(I_A), "i_a has the wrong sign"),
        (turned(I_B), "i_b has the wrong sign"),
        (turned(I_A, I_B), "both currents have the wrong sign"),
        (swapped(I_A, I_B), "i_a and i_b are swapped"),
        (phases_a_and_c, "phases a and c are swapped"),
        (phases_b_and_c, "two phases are swapped"),
        (turned(U_BETA), "u_beta has the wrong sign"),
        (swapped(U_ALPHA, U_BETA), "u_alpha and u_beta are swapped"),
        (scaled(I_B, 0.5), "i_b is 0.5 times -i_a / 2"),
        (moved(1), "a row too late; move u_alpha and u_beta up"),
        (moved(2), "2 rows too late"),
        (moved(-1), "a row too early; move u_alpha and u_beta down"),
        (scaled(I_A, 1.1), ""),
    ],
)
def test_what_is_wrong_is_named(
    measured: tuple[Simulated, Identified], change: Wrong, said: str
) -> None:
    parts = spoilt(measured[0].parts, change)
    if not said:
        require_answers(parts, MOTOR, "log")
        return
    with pytest.raises(UserError, match=said):
        require_answers(parts, MOTOR, "log")


def test_a_log_that_the_current_limit_ended_says_so(
    measured: tuple[Simulated, Identified],
) -> None:
    parts = spoilt(measured[0].parts[:5], lambda rows: None)
    parts[4].rows[30, I_A] = 0.99 * min(MOTOR.i_trip, MOTOR.adc_range)
    with pytest.raises(UserError, match=f"stage {parts[4].stage}: current above .* in row 30"):
        require_answers(parts, MOTOR, "log")


def held(u_alpha: float, i_a: Floats, i_b: Floats) -> Part:
    """As many rows as currents, at rising voltages along phase a."""
    rows = np.zeros((len(i_a), len(NUMBERS)))
    rows[:, U_ALPHA] = u_alpha * np.arange(1.0, len(i_a) + 1.0)
    rows[:, I_A], rows[:, I_B] = i_a, i_b
    return Part("hold", rows)


def test_the_offset_of_a_channel_is_no_sign() -> None:
    """i_b falls by half of what i_a rises by, from 3 A on."""
    rise = np.array([1.0, 2.0, 3.0])
    require_answers([held(10.0, rise, 3.0 - 0.5 * rise)], MOTOR, "log")
    with pytest.raises(UserError, match="i_b has the wrong sign"):
        require_answers([held(10.0, rise, 0.5 * rise - 3.0)], MOTOR, "log")


def test_currents_that_do_not_answer_at_all_have_no_sign() -> None:
    require_answers([held(10.0, np.zeros(3), np.zeros(3))], MOTOR, "log")


@pytest.mark.parametrize(("share", "beyond"), [(0.84, False), (0.86, True)])
def test_the_limit_is_one_of_the_vector(share: float, beyond: bool) -> None:
    """i_b alone is a vector 2 / sqrt(3) times as long, and 0.98 of the least limit ends a test."""
    parts = [held(0.0, np.zeros(1), np.array([share * min(MOTOR.i_trip, MOTOR.adc_range)]))]
    if not beyond:
        require_answers(parts, MOTOR, "log")
        return
    with pytest.raises(UserError, match=r"above .* in row 0"):
        require_answers(parts, MOTOR, "log")


def test_the_command_refuses_such_a_log(
    measured: tuple[Simulated, Identified], tmp_path: Path
) -> None:
    write_log(spoilt(measured[0].parts, turned(I_B)), tmp_path / "log.csv")
    words = ("identify", "machine", "--motor", MOTOR.name, "--log", str(tmp_path / "log.csv"))
    done = CliRunner().invoke(app, words)
    assert isinstance(done.exception, UserError) and "i_b has the wrong" in str(done.exception)
