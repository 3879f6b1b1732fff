"""The check of the installation on simulated drives, and the command that reads its result."""

import warnings
from pathlib import Path

import numpy as np
import pytest

from sensorless.core.bring_up import FAULTS, WIRINGS
from sensorless.errors import UserError
from sensorless.identify.bring_up.check import check, check_log, drives_at_rest, write_log
from sensorless.identify.bring_up.mistakes import MISTAKES
from sensorless.identify.bring_up.survey import count_pole_pairs, survey, turning_drive
from sensorless.identify.bring_up.words import CURE, WIRING
from sensorless.machine.motor import Motor
from tests.helpers.command import run

SEEDS = np.arange(500, 506, dtype=np.uint64)
HARD = ("compensated-", "duty-power", "delay-1.5")
"""Found often, not always; docs/bring-up.md has the rates."""


@pytest.mark.parametrize("name", ["paper", "ebike_hub", "pmsyrm_5600w"])
def test_every_mistake_is_found_and_none_where_there_is_none(name: str) -> None:
    for what, n in survey(Motor.load(name), SEEDS):
        if what == "right":
            assert n.flagged == 0
        else:
            least = n.drives - 2 if what.startswith(HARD) else n.drives
            assert n.named >= least, what


def test_the_pole_pairs_of_the_machine_are_counted(motor: Motor) -> None:
    assert count_pole_pairs(turning_drive(motor, 7)) == motor.n_p


def test_a_log_gives_the_same_answer(motor: Motor, tmp_path: Path) -> None:
    """Rounded to nine digits, as written; one that is cut off is refused."""
    drive = drives_at_rest(motor, SEEDS[:1])
    for mistake in (MISTAKES["delay-2"], MISTAKES["current-ab-swapped"]):
        found, rows = check(motor, drive, mistake)
        write_log(rows, tmp_path / "log.csv")
        assert check_log(motor, tmp_path / "log.csv") == found
    write_log(rows[:50], tmp_path / "short.csv")
    with pytest.raises(UserError, match="ends after 50 periods"):
        check_log(motor, tmp_path / "short.csv")
    (tmp_path / "other.csv").write_text("t,x\n1,2\n")
    with pytest.raises(UserError, match="columns i_a and i_b"):
        check_log(motor, tmp_path / "other.csv")
    (tmp_path / "empty.csv").write_text("")
    with warnings.catch_warnings(), pytest.raises(UserError, match="columns i_a and i_b"):
        warnings.simplefilter("error")
        check_log(motor, tmp_path / "empty.csv")


def test_there_are_words_for_everything() -> None:
    assert set(CURE) == set(FAULTS) and set(WIRING) == set(WIRINGS)
    assert {word for m in MISTAKES.values() for word in m.shows} <= set(FAULTS)


def test_the_command(tmp_path: Path) -> None:
    words = ("identify", "bring-up", "--mistake", "current-bc-swapped", "--save-log", "x.csv")
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 1 and "phases b and c are swapped" in done.stdout
    assert run("identify", "bring-up", "--log", "x.csv", cwd=tmp_path).stdout == done.stdout
    done = run("identify", "bring-up", "--mistake", "right", cwd=tmp_path)
    assert done.returncode == 0 and "built in right" in done.stdout
    done = run("identify", "bring-up", "--mistake", "no", cwd=tmp_path)
    assert done.returncode != 0 and "choose right, delay-0" in done.stderr
