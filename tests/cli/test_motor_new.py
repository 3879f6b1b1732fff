"""From a datasheet to a checked motor file: questions, options and what is assumed."""

import inspect
import io
import math
import re
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, get_args, get_type_hints

import pytest
from typer.testing import CliRunner

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

from sensorless.cli.app import app
from sensorless.cli.motor_new import new_command
from sensorless.design.drive import DriveDesign
from sensorless.design.new_motor import START_TIME, new_motor
from sensorless.machine.datasheet import Datasheet
from sensorless.machine.motor import Motor
from tests.helpers.command import run

DATA = Path(__file__).parents[1] / "data"
SHEET = {
    "name": "mine", "out": "mine.toml", "poles": "6", "speed": "1500", "torque": "14",
    "current": "4.3", "ke": "209.7", "r": "7.2", "l-d": "0.072", "l-q": "0.102",
    "inertia": "150 kg cm2", "u-dc": "540", "pwm": "5000", "size": "8",
}  # fmt: skip
"""The machine of ipmsm_2200w as a datasheet would put it."""


def words(**changes: str | None) -> list[str]:
    given = {**SHEET, **{key.replace("_", "-"): value for key, value in changes.items()}}
    return [w for key, value in given.items() if value is not None for w in (f"--{key}", value)]


def test_a_sheet_becomes_the_machine_it_describes(tmp_path: Path) -> None:
    done = run("motor", "new", *words(), cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    made, known = Motor.load(tmp_path / "mine.toml"), Motor.load("ipmsm_2200w")
    for name in ("n_p", "R_s", "L_d", "L_q", "psi_f", "J", "tau_rated", "i_rated", "T_s"):
        assert getattr(made, name) == pytest.approx(getattr(known, name), rel=2e-3), name
    assert made.i_max == pytest.approx(1.5 * made.i_rated, rel=1e-4)
    assert made.u_inj == pytest.approx(known.u_inj, rel=0.1)
    assert "suitable: yes" in done.stdout
    text = (tmp_path / "mine.toml").read_text(encoding="utf-8")
    assert 'psi_f = "datasheet: Ke = 209.7 V/krpm line to line rms"' in text
    assert 'dead_time = "assumed: usual for IGBTs' in text
    assert len(re.findall(r"^\w+ += ", text, re.MULTILINE)) == 2 + 2 * 18, "a source each"
    again = words(name="other", size="0")
    assert run("motor", "new", *again, cwd=tmp_path).returncode == 2
    assert (tmp_path / "mine.toml").read_text(encoding="utf-8") == text
    assert run("motor", "new", *again, "--replace", cwd=tmp_path).returncode == 0
    assert Motor.load(tmp_path / "mine.toml").name == "other"


def sheets() -> dict[str, Any]:
    return tomllib.loads((DATA / "datasheets.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", sheets())
def test_real_machines_pass_or_are_refused_for_a_reason(name: str, tmp_path: Path) -> None:
    sheet = sheets()[name]
    given = {"name": name, "out": "mine.toml", "size": "0", **sheet["options"]}
    done = run("motor", "new", *(w for k, v in given.items() for w in (f"--{k}", v)), cwd=tmp_path)
    said = " ".join((done.stdout + done.stderr).split()).replace("because - ", "because ")
    status = {"yes": 0, "with": 0, "no,": 1}.get(sheet["verdict"].split()[0], 2)
    judged = status < 2
    assert done.returncode == status
    assert (tmp_path / "mine.toml").exists() is judged
    assert (f"suitable: {sheet['verdict']}" if judged else sheet["verdict"]) in said


def test_the_page_tells_every_sheet_and_its_verdict() -> None:
    text = (DATA.parents[1] / "docs" / "motor-check.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split("|")] for line in text.splitlines()]
    told = {row[1].split("`")[1]: row[4] for row in rows if len(row) == 8 and "`" in row[1]}
    assert set(told) >= set(sheets())
    for name, sheet in sheets().items():
        word = sheet["verdict"].split(",")[0]
        assert told[name].startswith("refused" if word == "saliency" else word), name


def test_an_impossible_magnet_is_named(tmp_path: Path) -> None:
    """Not a saturation that no sheet gives."""
    done = run("motor", "new", *words(ke="1e9", torque="14", size="0"), cwd=tmp_path)
    assert done.returncode == 2 and "cancel the magnet" in done.stderr
    assert "saturation" not in done.stderr and not list(tmp_path.iterdir())


def test_what_is_missing_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    given = words(poles=None, ke=None, torque=None, size="0")
    done = CliRunner().invoke(app, ["motor", "new", *given], input="6\n209.7\n14\n")
    assert done.exit_code == 0, done.output
    assert Motor.load(tmp_path / "mine.toml").psi_f == pytest.approx(0.545, rel=2e-3)


def test_the_mean_inductance_is_asked_for_where_the_ratio_is_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """87 mH between two terminals are 43.5 mH a phase, 2/5 and 3/5 of twice that."""
    monkeypatch.chdir(tmp_path)
    given = words(l_d=None, l_q=None, ratio="1.5", size="0")
    done = CliRunner().invoke(app, ["motor", "new", *given], input="0.087\n")
    assert done.exit_code == 0 and "mean inductance" in done.output, done.output
    made = Motor.load(tmp_path / "mine.toml")
    assert (made.L_d, made.L_q) == pytest.approx((0.0348, 0.0522))


def test_what_is_said_of_the_inverter_is_in_the_file(tmp_path: Path) -> None:
    """Beside a mean inductance and its ratio, nothing is asked."""
    given = words(
        l_d=None, l_q=None, l="0.087", ratio="1.5", adc_bits="10", adc_range="20",
        dead_time="1.5e-6", u_inj="90", size="0",
    )  # fmt: skip
    done = run("motor", "new", *given, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    made = Motor.load(tmp_path / "mine.toml")
    assert (made.adc_bits, made.adc_range, made.u_inj) == (10, 20.0, 90.0)
    assert (made.dead_time, made.L_q) == pytest.approx((1.5e-6, 0.0522))


@pytest.mark.parametrize("as_json", [False, True])
def test_a_machine_that_does_not_suit_may_be_replaced(as_json: bool, tmp_path: Path) -> None:
    more = ["--json"] if as_json else []
    done = run("motor", "new", *words(l_q="0.0745", size="0"), *more, cwd=tmp_path)
    assert done.returncode == 1 and (tmp_path / "mine.toml").exists()
    assert ("add --replace" in done.stderr) != as_json


WRONG = {
    "poles": ("7", "poles: 7; give twice the pole pairs: 2, 4, 6, ..., 200"),
    "r": ("-1", "r: -1 ohm; give a finite number above 0"),
    "pwm": ("5", "pwm: 5 Hz; give 1000 to 1e+06 Hz"),
    "ke": ("inf", "ke: inf V; give a finite number above 0"),
    "l-d": ("72 mH", "l-d: '72 mH'; give a number without its unit"),
}
"""Answers that cannot be, and what is said of them."""


def test_a_wrong_answer_is_asked_again_on_a_terminal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At once: each answer that follows is the right one to the same question."""
    monkeypatch.chdir(tmp_path)
    terminal = SimpleNamespace(stdin=SimpleNamespace(isatty=lambda: True))
    monkeypatch.setattr("sensorless.cli.motor_new.sys", terminal)
    given = words(poles=None, r=None, pwm=None, ke=None, l_d=None, l_q=None, size="0")
    answers = [x for key, (wrong, _) in WRONG.items() for x in (wrong, SHEET[key])]
    answers.append(SHEET["l-q"])
    done = CliRunner().invoke(app, ["motor", "new", *given], input="\n".join(answers) + "\n")
    assert done.exit_code == 0, done.output
    assert all(done.output.count(said) == 1 for _, said in WRONG.values())
    assert Motor.load(tmp_path / "mine.toml").L_d == pytest.approx(0.036)


@pytest.mark.parametrize("key", WRONG)
def test_a_wrong_answer_of_a_script_ends_the_command(
    key: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """So does a wrong option, before the first question."""
    monkeypatch.chdir(tmp_path)
    wrong, said = WRONG[key]
    monkeypatch.setattr("sys.stdin", io.StringIO(f"{wrong}\n{SHEET[key]}\n"))
    pair = {"l-q": None} if key == "l-d" else {}
    done = run("motor", "new", *words(**{key: None}, **pair), cwd=tmp_path)
    assert done.returncode == 2 and said in done.stderr
    if wrong != "72 mH":
        done = run("motor", "new", *words(**{key: wrong}, speed=None), cwd=tmp_path)
        assert done.returncode == 2 and said in done.stderr and "r/min]" not in done.stdout
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"kt": "5"}, "Kt = 5 N m/A"),
        ({"power": "5000"}, "5000 W at 1500 r/min"),
        ({"l-q": "0.072"}, "without saliency"),
        ({"l-q": "0.05"}, "L_q must exceed L_d"),
        ({"u-dc": "-1"}, "u-dc: -1 V"),
        ({"ke": "-41"}, "ke: -41 V"),
        ({"r": "inf"}, "r: inf ohm"),
        ({"l-d": "nan"}, "l-d: nan H"),
        ({"inertia": "-3 g cm2"}, "inertia: -3e-07 kg m2"),
        ({"pwm": "0"}, "pwm: 0 Hz"),
        ({"pwm": "1e9"}, "pwm: 1e+09 Hz; give 1000 to 1e+06 Hz"),
        ({"speed": "0"}, "speed"),
        ({"inertia": "much"}, "inertia"),
        ({"out": "no/such/mine.toml"}, "no/such"),
        ({"poles": None}, "--poles"),
        ({"name": "a\nb"}, r"error: name: 'a\nb': leave out control characters"),
    ],
)
def test_a_wrong_sheet_is_one_line_and_no_file(
    changes: dict[str, str | None], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", open("/dev/null", encoding="utf-8"))
    done = run("motor", "new", *words(**changes), cwd=tmp_path)
    assert done.returncode == 2
    assert said in done.stderr
    assert not list(tmp_path.iterdir())


def test_the_help_names_the_values_that_are_assumed() -> None:
    """Figures in the help of ``motor new`` are those of the code."""
    hints = get_type_hints(new_command, include_extras=True)
    helps = {
        name: str(get_args(hints[name])[1].help)
        for name in inspect.signature(new_command).parameters
    }
    short, long = (float(x) for x in re.findall(r"\d\S*e-6", helps["dead_time"]))
    (limit,) = (float(x) for x in re.findall(r"below (\d+) V", helps["dead_time"]))
    sheet = Datasheet(poles=6, speed_rpm=1500, current_rms=4.3, R=7.2, ke=209.7, torque=14.0,
                      L_d=0.072, L_q=0.102)  # fmt: skip
    for volt, pwm, dead_time in (
        (limit - 1.0, 1e3, short),
        (limit, 1e3, long),
        (limit, 2e4, 0.02 / 2e4),
    ):
        made = new_motor("mine", sheet, u_dc=volt, pwm_hz=pwm, design=DriveDesign())
        assert made["drive"]["dead_time"] == pytest.approx(dead_time)
        assert made["drive"]["adc_range"] == pytest.approx(2.0 * math.sqrt(2.0) * 4.3, rel=1e-4)
    assert f"{START_TIME:g} s from rest" in helps["inertia"]
    assert (
        "at most 2 %" in helps["dead_time"] and "twice the peak of the rated" in helps["adc_range"]
    )
