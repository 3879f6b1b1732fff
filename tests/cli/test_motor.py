"""What the check of a motor says on screen and page, and a motor file from a flux map."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sensorless.cli.options import say_if_unsuited
from sensorless.design.drive import DriveDesign
from sensorless.machine import map_fit
from sensorless.machine.magnetics import Floats, flux
from sensorless.machine.map_fit import MapFit
from sensorless.machine.motor import MOTORS, Motor, Saturation
from tests.helpers.command import run
from tests.helpers.machines import MEASURED_MAP


def test_the_page_has_all_that_the_screen_has(tmp_path: Path) -> None:
    words = ["paper", "--size", "16", "--out", "page.html", "--set", "estimator=coupled"]
    done = run("motor", "check", *words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    for text in ("suitable: yes", "4.54 at rest", "u_inj = 53 V", "16 stress", "16 mismatch"):
        assert text in " ".join(done.stdout.split())
        assert text in page
    assert "Quick runs under Eq. 25, on the default drive" in page
    assert f"Made by <code>sensorless motor check {' '.join(words)}</code>" in page
    assert page.count("data-curves=") == 4
    assert len(done.stdout.splitlines()) < 40, "one screen"


def test_the_page_says_which_drive_it_judged(tmp_path: Path) -> None:
    words = ["paper", "--size", "2", "--set", "estimator=smo", "--set", "speed_hz=4"]
    run("motor", "check", *words, "--out", "page.html", cwd=tmp_path)
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Quick runs under Eq. 25, with speed_hz=4, estimator=smo</h2>" in page
    assert f"Made by <code>sensorless motor check {' '.join(words)} --out page.html</code>" in page


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
    assert "note: u_inj" not in done.stdout
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


def test_a_map_of_one_half_leaves_the_pole_to_the_user(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the map cannot show, the file says; what the base motor's file says too, it keeps."""
    known = Motor.load("paper")
    axes = np.meshgrid(np.linspace(-6.8, 0.0, 9), np.linspace(-6.8, 6.8, 17), indexing="ij")
    i = np.stack([x.ravel() for x in axes], axis=-1)
    psi = flux(known.saturation, i)
    fit = MapFit(known.saturation, i, psi, 0.0 * i, known.i_rated, known.i_max)
    monkeypatch.setattr(map_fit, "fit_map", lambda *_: fit)
    head = "i_d [A],i_q [A],psi_d [Vs],psi_q [Vs]"
    np.savetxt(tmp_path / "half.csv", np.c_[i, psi], delimiter=",", header=head, comments="")
    text = (MOTORS / "paper.toml").read_text(encoding="utf-8")
    own = text.replace("[drive]\n", "[drive]\nspeed_hz = 1.5\n").replace(
        "u_inj = 50.0", "u_inj = 11.0"
    )
    (tmp_path / "mine.toml").write_text(own, encoding="utf-8")
    words = ["half.csv", "--motor", "mine.toml"]
    done = run("motor", "import-map", *words, "--out", "made.toml", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "so pole_at_rest = false" in " ".join(done.stdout.split())
    assert "note: u_inj stays at 11 V; with this map" in " ".join(done.stdout.split())
    made = Motor.load(tmp_path / "made.toml")
    assert not made.pole_at_rest and made.speed_hz == 1.5
    text = (tmp_path / "made.toml").read_text(encoding="utf-8")
    assert 'pole_at_rest = "flux map half.csv, which' in text
    assert 'speed_hz = "as in mine.toml"' in text
    again = run("motor", "check", "made.toml", "--size", "0", cwd=tmp_path)
    assert "its file says pole_at_rest = false" in " ".join(again.stdout.split())
    printed = run("motor", "import-map", *words, cwd=tmp_path)
    assert "[drive]\npole_at_rest = false" in printed.stdout


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
    for command in ("simulate", "export eq25 --out out", "demo --out out", "pil eq25 --out p.json"):
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
