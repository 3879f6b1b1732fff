"""The check of the installation on simulated drives, and the command that reads its result."""

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sensorless.core.bring_up import FAULTS, WIRINGS
from sensorless.envs.scenarios.machine_family import member
from sensorless.errors import UserError
from sensorless.identify.bring_up.check import (
    Found,
    check,
    check_log,
    drives_at_rest,
    params_of,
    write_log,
)
from sensorless.identify.bring_up.mistakes import MISTAKES
from sensorless.identify.bring_up.pulses import shows_others
from sensorless.identify.bring_up.survey import count_pole_pairs, survey, turning_drive
from sensorless.identify.bring_up.words import CURE, FAR, OTHERS, WIRING, verdict
from sensorless.machine.motor import MOTORS, Motor, Saturation
from sensorless.observers.bring_up_design import plan_bring_up
from tests.helpers.command import run

SEEDS = np.arange(500, 506, dtype=np.uint64)
HARD = ("compensated-", "duty-power", "delay-1.5", "channel-a-gain", "channel-b-gain",
        *(f"duty-{x}-stuck" for x in "abc"))  # fmt: skip
"""Found often, not always; docs/bring-up.md has the rates."""


@pytest.mark.parametrize("name", ["paper", "ebike_hub", "pmsyrm_5600w"])
def test_every_mistake_is_found_and_none_where_there_is_none(name: str) -> None:
    for what, n in survey(Motor.load(name), SEEDS):
        if what == "right":
            assert n.flagged == 0
        else:
            least = n.drives - 2 if what.startswith(HARD) else n.drives
            assert n.named >= least, what


@pytest.mark.parametrize("index", [51, 55, 159, 169])
def test_a_right_drive_whose_iron_saturates_is_not_flagged(index: int) -> None:
    """The inductances are those of the currents that count: from zero they are 20 % larger."""
    motor = member(424242, index)
    params = params_of(motor)[0]
    assert params["L_d"] < 0.86 * motor.L_d and params["L_high"] < params["L_low"]
    drives = drives_at_rest(motor, np.arange(424242, 424262, dtype=np.uint64))
    found = [check(motor, drives[j : j + 1])[0].faults for j in range(len(drives))]
    assert sum(map(bool, found)) <= 2
    half = [check(motor, drives[j : j + 1], MISTAKES["duty-half"])[0].faults for j in range(4)]
    assert all(half)


@pytest.mark.parametrize("L_d", [6e-4, 3e-4])
def test_a_right_drive_with_short_pushes_is_not_flagged(L_d: float) -> None:
    """A small inductance, which loses a push to dead time; if it cannot be judged, that is said."""
    spindle = replace(
        Motor.load("paper"), name="spindle", n_p=2, R_s=0.15, L_d=L_d, L_q=1.5 * L_d,
        psi_f=0.022, J=3e-5, B=0.0, tau_rated=0.6, i_rated=10.0, n_rated_rpm=24000.0, u_dc=230.0,
        T_s=6.25e-5, u_inj=18.0, i_max=15.0, i_trip=28.0, dead_time=1e-6, adc_range=30.0,
        saturation=Saturation.linear(L_d, 1.5 * L_d, 0.022),
    )  # fmt: skip
    drives = drives_at_rest(spindle, SEEDS)
    for j in range(len(drives)):
        assert check(spindle, drives[j : j + 1])[0].faults == ()
        for name in ("duty-half", "duty-double", "duty-root-3"):
            assert check(spindle, drives[j : j + 1], MISTAKES[name])[0].faults, name
    plan = plan_bring_up(spindle)
    if L_d == 6e-4:
        assert plan.u_lost > 0.0 and not plan.limits
        flagged = check(spindle, drives[:1], MISTAKES["compensated-1"])[0].faults
        assert flagged == ("dead_time",)
    else:
        assert plan.u_lost == 0.0 and "pulses are short" in plan.limits[0]
        assert "48 % unseen" in plan.limits[1]


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
    with pytest.raises(UserError, match="give --motor the file of the export"):
        check_log(motor, tmp_path / "short.csv")
    (tmp_path / "other.csv").write_text("t,x\n1,2\n")
    with pytest.raises(UserError, match="no column i_a; give i_a and i_b"):
        check_log(motor, tmp_path / "other.csv")
    (tmp_path / "empty.csv").write_text("")
    with pytest.raises(UserError, match="no rows; give one per PWM period"):
        check_log(motor, tmp_path / "empty.csv")


def test_a_log_reads_the_same_as_a_tool_writes_it(motor: Motor, tmp_path: Path) -> None:
    found, rows = check(motor, drives_at_rest(motor, SEEDS[:1]))
    lines = [f"{1e3 * a:.6f};{1e3 * b:.6f}".replace(".", ",") for a, b, *_ in rows]
    text = "\n".join(["# scope", "i_a [mA];i_b [mA]", *lines]) + "\n"
    (tmp_path / "log.csv").write_text(text, encoding="utf-8-sig")
    told = check_log(motor, tmp_path / "log.csv")
    assert told.faults == found.faults and told.R_s == pytest.approx(found.R_s, rel=1e-4)


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("nan,nan,0,0", "line 50: i_a: 'nan'; give a finite number"),
        ("1", "line 50: 1 values; give 4"),
    ],
)
def test_a_bad_row_of_a_log_is_named(motor: Motor, tmp_path: Path, row: str, said: str) -> None:
    path = tmp_path / "log.csv"
    write_log(check(motor, drives_at_rest(motor, SEEDS[:1]))[1], path)
    lines = path.read_text(encoding="utf-8").splitlines()
    lines[49] = row
    path.write_text("\n".join(lines) + "\n", encoding="utf-16")
    with pytest.raises(UserError, match=said):
        check_log(motor, path)
    with pytest.raises(UserError, match="No such file"):
        check_log(motor, tmp_path / "none.csv")


def test_a_log_of_another_motor_gives_no_impossible_numbers(motor: Motor, tmp_path: Path) -> None:
    other = replace(motor, u_dc=0.5 * motor.u_dc)
    write_log(check(other, drives_at_rest(other, SEEDS[:1]))[1], tmp_path / "log.csv")
    found = check_log(motor, tmp_path / "log.csv")
    assert "scale" in found.faults and abs(found.lost) > FAR
    assert found.other_pulses
    text = " ".join(verdict(replace(found, other_pulses=False)))
    assert "is --motor the file of the export?" in text and "ohm" not in text


@pytest.mark.parametrize(("name", "other"), [("paper", "ebike_hub"), ("ebike_hub", "paper")])
def test_a_log_of_other_pulses_is_told(name: str, other: str, tmp_path: Path) -> None:
    motor, path = Motor.load(name), tmp_path / "log.csv"
    rows = check(motor, drives_at_rest(motor, SEEDS[:1]))[1]
    write_log(rows, path)
    found = check_log(Motor.load(other), path)
    assert found.other_pulses and verdict(found) == [OTHERS]
    assert check_log(motor, path).faults == ()
    done = run("identify", "bring-up", "--motor", other, "--log", str(path), cwd=tmp_path)
    assert done.returncode == 1 and "not a log of this check" in done.stdout


def test_between_which_shipped_motors_logs_are_told_apart() -> None:
    """As docs/bring-up.md counts them."""
    motors = [Motor.load(path.stem) for path in sorted(MOTORS.glob("*.toml"))]
    logs = {m.name: check(m, drives_at_rest(m, SEEDS[:1]))[1] for m in motors}
    alike = {
        (name, other.name)
        for name, rows in logs.items()
        for other in motors
        if other.name != name and not shows_others(params_of(other), rows[:, 0], rows[:, 1])
    }
    assert alike == {
        ("brusa_hsm1", "ipmsm_2200w"),
        ("ipmsm_2200w", "brusa_hsm1"),
        ("pmsyrm_5600w", "brusa_hsm1"),
        ("pmsyrm_5600w", "ipmsm_2200w"),
    }


def test_a_log_that_begins_late_is_told(motor: Motor, tmp_path: Path) -> None:
    rows = check(motor, drives_at_rest(motor, SEEDS[:1]))[1]
    write_log(np.concatenate([rows[5:], rows[:8]]), tmp_path / "log.csv")
    assert verdict(check_log(motor, tmp_path / "log.csv")) == [OTHERS]


@pytest.mark.parametrize("name", ["paper", "formula_wheel", "pmsrm_15kw", "pmsyrm_5600w"])
def test_no_mistake_makes_a_log_look_like_another_motors(name: str) -> None:
    """Also where the log goes on at rest after the check has ended early."""
    motor = Motor.load(name)
    params, drives = params_of(motor), drives_at_rest(motor, SEEDS[:2])
    for j, mistake in itertools.product(range(len(drives)), MISTAKES.values()):
        i_a, i_b = check(motor, drives[j : j + 1], mistake)[1][:, :2].T
        assert not shows_others(params, i_a, i_b)
        rest = np.arange(1500) % 8
        longer = [np.concatenate([x, x[rest]]) for x in (i_a, i_b)]
        assert not shows_others(params, *longer)


def test_there_are_words_for_everything() -> None:
    assert set(CURE) == set(FAULTS) and set(WIRING) == set(WIRINGS)
    assert {word for m in MISTAKES.values() for word in m.shows} <= set(FAULTS)


def test_the_command(tmp_path: Path) -> None:
    words = ("identify", "bring-up", "--mistake", "current-bc-swapped", "--save-log", "x.csv")
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 1 and "phases b and c are swapped" in done.stdout
    assert run("identify", "bring-up", "--log", "x.csv", cwd=tmp_path).stdout == done.stdout
    done = run("identify", "bring-up", "--mistake", "right", cwd=tmp_path)
    assert done.returncode == 0 and "integrated correctly" in done.stdout
    text = (MOTORS / "paper.toml").read_text(encoding="utf-8")
    (tmp_path / "little.toml").write_text(text.replace("dead_time = 2.0e-6", "dead_time = 2e-7"))
    done = run("identify", "bring-up", "--mistake", "right", "--motor", "little.toml", cwd=tmp_path)
    assert done.returncode == 0 and "dead time is not judged, because its 0.54 V" in done.stdout
    done = run("identify", "bring-up", "--mistake", "no", cwd=tmp_path)
    assert done.returncode != 0 and "choose right, delay-0" in done.stderr


def test_nothing_is_said_of_what_was_not_measured() -> None:
    """A check that ends before its pulses knows no delay; one duty alone is two faults at once."""
    deaf = verdict(Found(("deaf",), "right", 0.0, 0.0, 1.0, 0.0))
    assert not any("wiring" in line or "delay" in line for line in deaf)
    sign = verdict(Found(("sign",), "right", 1.0, 0.0, 1.0, 0.0))
    assert "the order is right" in sign[0] and not any("one duty alone" in line for line in sign)
    both = verdict(Found(("sign", "phases"), "unknown", 1.0, 0.0, 1.0, 0.0))
    assert any("one duty alone" in line for line in both)
