"""The log of an identification reads back as it was measured."""

import re
from pathlib import Path

import numpy as np
import pytest

from sensorless.errors import UserError
from sensorless.identify.machine import procedure
from sensorless.identify.machine.log import COLUMNS, NUMBERS, Part, plausible, read_log, write_log
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.source import Recorded, outlier
from sensorless.machine.motor import Motor


def parts() -> list[Part]:
    rng = np.random.default_rng(0)
    rows = rng.normal(size=(5, 8)).astype(np.float32).astype(np.float64)
    rows[:, 0] = 0.0
    return [Part("offset", rows), Part("ramp", 3.0e-5 * rows), Part("offset", rows[:2])]


def test_numbers_come_back_to_the_bit(tmp_path: Path) -> None:
    wanted = [Part(p.stage, p.rows.astype(np.float32).astype(np.float64)) for p in parts()]
    write_log(wanted, tmp_path / "log.csv")
    found = read_log(tmp_path / "log.csv")
    assert [p.stage for p in found] == ["offset", "ramp", "offset"]
    for a, b in zip(found, wanted, strict=True):
        assert np.array_equal(a.rows, b.rows)


def test_columns_may_stand_in_any_order(tmp_path: Path) -> None:
    order = COLUMNS[::-1]
    row = dict.fromkeys(COLUMNS, "0") | {"stage": "hold", "i_a": "2.5"}
    text = ",".join(order) + "\n" + ",".join(row[name] for name in order) + "\n"
    (tmp_path / "log.csv").write_text(text, encoding="utf-16")  # as PowerShell writes
    (part,) = read_log(tmp_path / "log.csv")
    assert part.stage == "hold" and part["i_a"][0] == 2.5 and part["u_alpha"][0] == 0.0


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "no rows"),
        ("part,i_a,i_b\n1,2,3\n", "no column stage"),
        (",".join(COLUMNS) + "\n1,hold,0,x,0,0,0,0,0,0\n", "line 2"),
        (",".join(COLUMNS) + "\n1,hold,0,nan,0,0,0,0,0,0\n", "finite"),
        (",".join(COLUMNS) + "\n1,hold,0,0,0,0,1e300,0,0,0\n", "line 2: i_a: '1e300'"),
        (",".join(COLUMNS) + "\n1,hold,0,0,0,0,0,0,0,0\n\n1,hold,0,0,0,0,0,0\n", "line 4"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path: Path, text: str, word: str) -> None:
    (tmp_path / "log.csv").write_text(text)
    with pytest.raises(UserError, match=word):
        read_log(tmp_path / "log.csv")


def test_a_log_reads_the_same_as_a_tool_writes_it(tmp_path: Path) -> None:
    """Semicolons, decimal commas, units, a comment, and a column more."""
    write_log(parts(), tmp_path / "log.csv")
    head, *lines = (tmp_path / "log.csv").read_text().splitlines()
    names = head.replace("i_a", "i_a [A]").replace("u_dc", "u_dc [V]") + ",note"
    text = "\n".join([names, *(f"{line},x" for line in lines)])
    text = "# bench 3\n" + text.replace(",", ";").replace(".", ",")
    (tmp_path / "tool.csv").write_text(text, encoding="utf-8-sig")
    for a, b in zip(read_log(tmp_path / "tool.csv"), read_log(tmp_path / "log.csv"), strict=True):
        assert a.stage == b.stage and np.array_equal(a.rows, b.rows)


def test_blank_lines_at_the_end_are_none(tmp_path: Path) -> None:
    write_log(parts(), tmp_path / "log.csv")
    with (tmp_path / "log.csv").open("a") as file:
        file.write("\n \n")
    assert len(read_log(tmp_path / "log.csv")) == 3


@pytest.mark.parametrize("channel", ["i_a", "i_b"])
def test_an_outlier_is_named_where_the_log_leads_elsewhere(channel: str) -> None:
    rows = np.random.default_rng(0).normal(size=(200, 8))
    right, wrong = Part("offset", rows), Part("probe", rows.copy())
    wrong.rows[50, NUMBERS.index(channel)] = 30.0
    source = Recorded([right, wrong, right])
    source.run("offset", [])
    source.run("probe", [])
    with pytest.raises(UserError, match=f"{channel} = 30 in row 50 of part 1, stage probe"):
        source.run("axis", [])


@pytest.mark.parametrize(("height", "named"), [(4.8, False), (5.2, True)])
def test_an_outlier_stands_five_times_beyond_the_next(height: float, named: bool) -> None:
    """Alone on a line, 1 beside its neighbours' mean, and 0.5 that of each neighbour."""
    rows = np.zeros((40, len(NUMBERS)))
    rows[:, NUMBERS.index("i_b")] = 5.0
    rows[[10, 30], NUMBERS.index("i_b")] += 1.0, height
    told = outlier([Part("hold", rows)])
    assert told == (
        f", or mend an outlier: i_b = {5.0 + height:g} in row 30 of part 0, stage hold"
        if named
        else ""
    )
    assert not outlier([Part("hold", rows[25:34])]), "too few rows"


def test_a_log_of_another_procedure_is_refused() -> None:
    source = Recorded(parts())
    source.run("offset", [])
    with pytest.raises(UserError, match="stage hold expected, stage ramp found"):
        source.run("hold", [])


@pytest.mark.parametrize(
    ("column", "value", "said"),
    [
        (4, 1000.0, "i_a = 1000 in row 3 of the stage, 1 of 5 rows"),
        (3, 1e6, "u_dc = 1e+06 in row 3 of the stage, 1 of 5 rows"),
        (3, 0.0, "u_dc = 0 in row 3 of the stage, 1 of 5 rows"),
        (0, -99.0, "segment = -99 in row 3 of the stage"),
        (0, 0.5, "segment = 0.5 in row 3 of the stage"),
        (0, 7.0, "segment = 7 in row 3 of the stage"),
        (4, -52.0, "i_a = -52 in row 3 of the stage"),  # three times the trip of 17 A
        (5, 52.0, "i_b = 52 in row 3 of the stage"),
        (5, -52.0, "i_b = -52 in row 3 of the stage"),
        (3, 179.0, "u_dc = 179 in row 3 of the stage"),  # a third of 540 V
        (3, 1621.0, "u_dc = 1621 in row 3 of the stage"),
    ],
)
def test_readings_that_the_drive_cannot_have_made_are_refused(
    column: int, value: float, said: str
) -> None:
    given, motor = parts(), Motor.load("paper")
    for part in given:
        part.rows[:, 3] = motor.u_dc
    assert plausible(given, motor, Path("log.csv")) is given
    given[1].rows[3, column] = value
    with pytest.raises(UserError, match=re.escape(f"stage ramp: {said}")):
        plausible(given, motor, Path("log.csv"))


def test_readings_that_a_drive_can_just_have_made_are_taken() -> None:
    given, motor = parts(), Motor.load("paper")
    for part in given:
        part.rows[:, 3] = motor.u_dc
    given[1].rows[:, 3] = (181.0, 181.0, 1619.0, 1619.0, 540.0)
    given[1].rows[1:3, 4:6] = 50.0, -50.0
    given[1].rows[:, 0] = (0.0, 0.0, 2.0, 4.0, 4.0)
    assert plausible(given, motor, Path("log.csv")) is given
    given[1].rows[3:, 0] = 5.0  # five rows have at most five commands, from 0 on
    with pytest.raises(UserError, match="segment = 5 in row 3"):
        plausible(given, motor, Path("log.csv"))


def test_readings_that_fit_no_machine_are_a_user_error(monkeypatch: pytest.MonkeyPatch) -> None:
    def singular(*_: object) -> None:
        raise np.linalg.LinAlgError("SVD did not converge")

    monkeypatch.setattr(procedure, "measure_offsets", singular)
    plate = Nameplate.of(Motor.load("paper"))
    with pytest.raises(UserError, match=r"SVD did not converge.*outliers"):
        procedure.identify_machine(Recorded([]), plate)


@pytest.mark.parametrize(
    ("unit", "share"), [(1.0, None), (60.0 / (2 * np.pi), "9.55"), (0.25, "0.25")]
)
def test_a_speed_in_another_unit_than_the_angle_is_refused(unit: float, share: str | None) -> None:
    """In r/min, or mechanical: the angle of the same rows tells."""
    motor = Motor.load("paper")
    omega = np.linspace(0.0, 300.0, 2000)
    rows = np.zeros((2000, 8))
    rows[:, COLUMNS.index("u_dc") - 2] = motor.u_dc
    rows[:, COLUMNS.index("theta") - 2] = np.mod(np.cumsum(omega) * motor.T_s, 2 * np.pi)
    rows[:, COLUMNS.index("omega") - 2] = unit * omega
    part = [Part("spin", rows)]
    if share is None:
        assert plausible(part, motor, Path("log.csv")) == part
    else:
        with pytest.raises(UserError, match=f"omega is {share} times what theta turns by"):
            plausible(part, motor, Path("log.csv"))
