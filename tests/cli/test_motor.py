"""From a data sheet to a checked motor file, and what the check says on screen and page."""

import inspect
import json
import math
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args, get_type_hints

import numpy as np
import pytest
from typer.testing import CliRunner

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

from sensorless.cli.app import app
from sensorless.cli.motor_new import new_command
from sensorless.cli.options import say_if_unsuited
from sensorless.design.drive import DriveDesign
from sensorless.design.new_motor import START_TIME, new_motor
from sensorless.machine import map_fit
from sensorless.machine.datasheet import Datasheet
from sensorless.machine.magnetics import Floats
from sensorless.machine.map_fit import MapFit
from sensorless.machine.motor import MOTORS, Motor, Saturation
from tests.helpers.command import run
from tests.helpers.machines import MEASURED_MAP

DATA = Path(__file__).parents[1] / "data"
SHEET = {
    "name": "mine", "out": "mine.toml", "poles": "6", "speed": "1500", "torque": "14",
    "current": "4.3", "ke": "209.7", "r": "7.2", "l-d": "0.072", "l-q": "0.102",
    "inertia": "150 kg cm2", "u-dc": "540", "pwm": "5000", "size": "8",
}  # fmt: skip
"""The machine of ipmsm_2200w as a data sheet would put it."""


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
    assert 'psi_f = "data sheet: Ke = 209.7 V/krpm line to line rms"' in text
    assert 'dead_time = "assumed: usual for IGBTs' in text
    assert len(re.findall(r"^\w+ += ", text, re.MULTILINE)) == 2 + 2 * 18, "a source each"


def sheets() -> dict[str, Any]:
    return tomllib.loads((DATA / "datasheets.toml").read_text(encoding="utf-8"))


@pytest.mark.parametrize("name", sheets())
def test_real_machines_pass_or_are_refused_for_a_reason(name: str, tmp_path: Path) -> None:
    sheet = sheets()[name]
    given = {"name": name, "out": "mine.toml", "size": "0", **sheet["options"]}
    done = run("motor", "new", *(w for k, v in given.items() for w in (f"--{k}", v)), cwd=tmp_path)
    said = " ".join((done.stdout + done.stderr).split())
    status = {"yes": 0, "with": 0, "no,": 1}.get(sheet["verdict"].split()[0], 2)
    judged = status < 2
    assert done.returncode == status
    assert (tmp_path / "mine.toml").exists() is judged
    assert (f"suitable: {sheet['verdict']}" if judged else sheet["verdict"]) in said


def test_the_page_tells_every_sheet_and_its_verdict() -> None:
    text = (DATA.parents[1] / "docs" / "bring-a-motor.md").read_text(encoding="utf-8")
    rows = [[cell.strip() for cell in line.split("|")] for line in text.splitlines()]
    told = {row[1].split("`")[1]: row[4] for row in rows if len(row) == 8 and "`" in row[1]}
    assert set(told) >= set(sheets())
    for name, sheet in sheets().items():
        word = sheet["verdict"].split(",")[0]
        assert told[name].startswith("refused" if word == "saliency" else word), name


def test_what_is_missing_is_asked_for(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    given = words(poles=None, ke=None, torque=None, size="0")
    done = CliRunner().invoke(app, ["motor", "new", *given], input="6\n209.7\n14\n")
    assert done.exit_code == 0, done.output
    assert Motor.load(tmp_path / "mine.toml").psi_f == pytest.approx(0.545, rel=2e-3)


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


def test_the_page_has_all_that_the_screen_has(tmp_path: Path) -> None:
    done = run("motor", "check", "paper", "--size", "16", "--out", "page.html", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    for text in ("suitable: yes", "4.54 at rest", "u_inj = 53 V", "quick run, 16 of suite stress"):
        assert text in " ".join(done.stdout.split())
        assert text in page
    assert page.count("data-curves=") == 4
    assert len(done.stdout.splitlines()) < 40, "one screen"


@pytest.mark.parametrize(
    ("old", "new", "said", "status"),
    [
        ("psi_f = 0.545 ", "psi_f = 8.0 ", "psi_f = 8", 1),
        ("L_q = 0.051 ", "L_q = 0.036 ", "no saliency", 1),
        ("L_q = 0.051 ", "L_q = 1e12 ", "L_q = 1e+12", 1),
        ("u_dc = 540.0 ", "u_dc = 300.0 ", "beyond 300 V", 0),
    ],
)
def test_the_verdict_names_the_reason(
    old: str, new: str, said: str, status: int, tmp_path: Path
) -> None:
    """A page is written and the status is 1 where the answer is no, whatever the numbers."""
    text = (MOTORS / "ipmsm_2200w.toml").read_text(encoding="utf-8")
    (tmp_path / "mine.toml").write_text(text.replace(old, new), encoding="utf-8")
    done = run("motor", "check", "mine.toml", "--size", "0", "--out", "page.html", cwd=tmp_path)
    assert done.returncode == status
    assert "suitable: yes" not in done.stdout
    assert said in " ".join(done.stdout.split())
    assert (tmp_path / "page.html").exists()


def known_as(fit: MapFit, patch: pytest.MonkeyPatch) -> None:
    """The fit itself is that of another test, if it is asked for with the same map."""
    known = Motor.load("pmsyrm_5600w")

    def fitted(i: Floats, psi: Floats, i_rated: float, i_max: float) -> MapFit:
        assert np.array_equal(i, fit.i) and np.array_equal(psi, fit.psi)
        assert (i_rated, i_max) == (known.i_rated, known.i_max)
        return fit

    patch.setattr(map_fit, "fit_map", fitted)


def test_a_flux_map_becomes_a_motor_file(
    tmp_path: Path, baldor: MapFit, monkeypatch: pytest.MonkeyPatch
) -> None:
    known_as(baldor, monkeypatch)
    words = ["--motor", "pmsyrm_5600w", "--out", "made.toml", "--plot", "fit.png"]
    done = run("motor", "import-map", str(MEASURED_MAP), *words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "within rated current: 0.65 and 0.49 RMS" in done.stdout
    made = Motor.load(tmp_path / "made.toml")
    assert made.saturation != Motor.load("pmsyrm_5600w").saturation
    assert "flux map baldor_400rpm_map.csv" in (tmp_path / "made.toml").read_text(encoding="utf-8")
    assert (tmp_path / "fit.png").read_bytes().startswith(b"\x89PNG")
    again = run("motor", "check", "made.toml", "--size", "0", cwd=tmp_path)
    assert "suitable: yes" in again.stdout


def test_a_map_that_no_model_fits_becomes_a_correction(
    tmp_path: Path, knee: MapFit, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One file to copy: the correction is in it, the check says so, a drive runs on it."""
    i, psi = knee.i, knee.psi
    known_as(knee, monkeypatch)
    head = "i_d [A],i_q [A],psi_d [Vs],psi_q [Vs]"
    np.savetxt(tmp_path / "knee.csv", np.c_[i, psi], delimiter=",", header=head, comments="")
    words = ["knee.csv", "--motor", "pmsyrm_5600w", "--plot", "fit.png", "--json"]
    done = run("motor", "import-map", *words, "--out", "made.toml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert max(found["within_rated_current"]["rms_percent"]) > 1.0
    assert max(found["corrected"]["rms_percent"]) < 0.5
    made = Motor.load(tmp_path / "made.toml")
    assert made.flux_correction is not None
    text = (tmp_path / "made.toml").read_text(encoding="utf-8")
    assert 'flux_correction = "flux map knee.csv: what [saturation] leaves' in text
    again = run("motor", "check", "made.toml", "--size", "0", cwd=tmp_path)
    assert "note: flux_correction" in again.stdout
    ran = run("simulate", "--motor", "made.toml", "--duration", "0.05", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr


def test_the_list_has_every_shipped_motor(tmp_path: Path) -> None:
    done = run("motors", cwd=tmp_path)
    assert done.returncode == 0
    names = [path.stem for path in MOTORS.glob("*.toml")]
    assert len(names) >= 6
    for name in names:
        assert name in done.stdout
    assert "4.54" in done.stdout and "yes" in done.stdout


def test_training_says_first_what_speaks_against_a_machine(tmp_path: Path) -> None:
    """A machine without saliency is refused before there is a run folder."""
    text = (MOTORS / "ipmsm_2200w.toml").read_text(encoding="utf-8")
    (tmp_path / "none.toml").write_text(text.replace("L_q = 0.051 ", "L_q = 0.036 "))
    done = run("train", "--name", "x", "--motor", "none.toml", "--steps", "1000", cwd=tmp_path)
    assert done.returncode == 2
    assert "without saliency" in done.stderr and done.stderr.count("\n") == 1
    assert not (tmp_path / "runs").exists()
    done = run("demo", "--motor", "none.toml", "--out", "demo", cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert not (tmp_path / "demo").exists()


def test_a_wrong_unit_is_refused_and_a_poor_machine_named_wherever_a_drive_runs(
    tmp_path: Path,
) -> None:
    text = (MOTORS / "ipmsm_2200w.toml").read_text(encoding="utf-8")
    (tmp_path / "wrong.toml").write_text(text.replace("psi_f = 0.545 ", "psi_f = 8.0 "))
    words = ["--motor", "wrong.toml"]
    for command in ("simulate", "export eq25 --out out", "demo --out out", "pil eq25 --out out"):
        done = run(*command.split(), *words, cwd=tmp_path)
        assert done.returncode == 2 and not (tmp_path / "out").exists()
        assert "motor 'ipmsm_2200w': psi_f = 8: no-load EMF at rated speed" in done.stderr
        assert "correct the motor file" in done.stderr and done.stderr.count("\n") == 1
    (tmp_path / "wrong.toml").write_text(text.replace("adc_bits = 12", "adc_bits = 6", 1))
    done = run("simulate", *words, "--duration", "0.02", cwd=tmp_path)
    assert done.returncode == 0 and done.stderr.count("\n") == 1
    assert "suitable: with limits, because angle noise of injection" in done.stderr


def test_weak_saliency_is_said_and_strong_is_not(capsys: pytest.CaptureFixture[str]) -> None:
    known = Motor.load("ipmsm_2200w")
    weak = replace(known, L_q=0.0385, saturation=Saturation.linear(known.L_d, 0.0385, known.psi_f))
    say_if_unsuited(weak, DriveDesign())
    assert "inductance ratio 1.07 within rated current" in " ".join(capsys.readouterr().err.split())
    say_if_unsuited(known, DriveDesign())
    assert not capsys.readouterr().err


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
    assert "at most 2 %" in helps["dead_time"] and "twice the rated" in helps["adc_range"]
