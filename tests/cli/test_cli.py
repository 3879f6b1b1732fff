"""The command line as a user meets it."""

import json
import os
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from sensorless.policies.shipped import FOLDER
from tests.helpers.command import process, run

GOLDEN = Path(__file__).parents[1] / "data" / "golden"
BEYOND = str(2**80)
"""Larger than any seed or index."""
LAST = str(2**63 - 1)
"""Largest seed of most commands."""
MACHINES = ["--policy", "eq25", "--suite", "machines", "--size", "1"]


@pytest.mark.parametrize(
    "command", ["", "simulate", "train", "evaluate", "report", "export", "demo"]
)
def test_help_teaches(command: str, tmp_path: Path) -> None:
    done = run(*([command] if command else []), "--help", cwd=tmp_path)
    assert done.returncode == 0
    assert len(done.stdout) > 300


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["evaluate", "--policy", "nobody"], "nobody"),
        (["evaluate", "--policy", "constant:1.5"], "constant"),
        (["evaluate", "--policy", "constant:nan"], "constant"),
        (["evaluate", "--policy", "eq25", "--suite", "easy"], "stress-1"),
        (["evaluate", "--policy", "eq25", "--motor", "nomotor"], "paper"),
        (["evaluate", "--policy", "eq25", "--set", "smo_pll_hz=many"], "smo_pll_hz"),
        (["evaluate", "--policy", "eq25", "--set", "smo_gain=3"], "smo_gain"),
        (["evaluate", "--policy", "eq25", "--out", "missing/results.json"], "missing"),
        (["simulate", "--speed", "0:200,x"], "speed"),
        (["simulate", "--speed", ""], "speed: '' cannot be read"),
        (["simulate", "--speed", "0:1e300"], "at most 3750 r/min"),
        (["simulate", "--load", "0:1e38"], "load: 1e+38 N m; give at most"),
        (["simulate", "--load", "0:0,1:-60"], "load: -60 N m; give at most"),
        (["simulate", "--duration", "1e-9"], "give 0.0002 s, one PWM period"),
        (["simulate", "--plot", "x.jpg"], "ends in .png or .html"),
        (["identify", "cross-coupling", "--plot", "x.svg"], "ends in .png"),
        (["evaluate", "--policy", "eq25", "--suite", "envelope", "--plot", "x"], "ends in .png"),
        (["simulate", "--scenario", "stress-1"], "SUITE:SEED:INDEX"),
        (["simulate", "--seed", BEYOND], "seed"),
        (["simulate", "--scenario", f"machines:{BEYOND}:0"], "seed"),
        (["simulate", "--scenario", f"machines:7:{BEYOND}"], "INDEX"),
        (["simulate", "--scenario", f"machines:{LAST}:0"], f"seed: {LAST}; give 0 to 9"),
        (["evaluate", *MACHINES, "--seed", LAST], f"seed: {LAST}; give 0 to 9223372036853775807"),
        (["tune", "linear", "--out", "t.json", "--seed", BEYOND], "seed"),
        (["identify", "machine", "--seed", BEYOND], "seed"),
        (["identify", "bring-up", "--seed", BEYOND], "seed"),
        (["simulate", "--start", "--theta-err", "200"], "theta_err"),
        (["simulate", "--spin", "4000"], "spin"),
        (["simulate", "--start", "--motor", "ipmsm_2200w"], "look alike"),
        (["simulate", "--scenario", "envelope:1:3"], "SIZE"),
        (["evaluate", "--policy", "linear:1,2", "--plot", "x.png"], "envelope"),
        (["evaluate", "--policy", "ramp-tune"], "ramp-tune"),
        (["demo", "--out", "d", "--size", "99999999999"], "size"),
        (["demo", "--out", "d", "--seed", BEYOND], "seed"),
        (["demo", "--out", "d", "--minutes", "0"], "error: minutes: 0: give more than 0"),
        (["report", "eq25"], "--out"),
        (["simulate", "--plant", "none.json"], "plant"),
        (["export", "hysteresis", "--out", "folder"], "what sensorless distill makes of"),
        (["export", "eq25", "--out", "/proc/nowhere"], "/proc"),
        (["train", "--name", "x", "--motor", "nomotor"], "nomotor"),
        (["train"], "--name"),
        (["train", "--name", "../../x"], "below runs/"),
        (["train", "--name", "/tmp/x"], "below runs/"),
        (["train", "--name", "a/../.."], "below runs/"),
        (["train", "--name", "n" * 300], "too long"),
        (["train", "--name", "a\nb"], r"name: 'a\nb': has control characters; use letters"),
        (["train", "--name", "a\x1b[31m"], r"name: 'a\x1b[31m': has control characters"),
        (["distill", "runs/x", "--name", "a\nb"], r"name: 'a\nb': has control characters"),
        (["distill", "runs/x", "--name", "../x"], "below runs/"),
        (["train", "--name", "\u202ea"], r"name: '\u202ea': has control characters"),
        (["simulate", "--out", "n" * 250 + ".csv"], "too long; give a name of at most 231 bytes"),
        (["replay", "n" * 300], "too long"),
        (["evaluate", "--policy", "eq25", "--out", "r.csv"], "a name that ends in .json"),
        (["tune", "linear", "--out", "lin.txt"], "a name that ends in .json"),
        (["simulate", "--out", "run.json"], "a name that ends in .csv"),
        (["motor", "check", "paper", "--out", "page.pdf"], "a name that ends in .html"),
        (["simulate", "--scenario", "machines:1:2", "--motor", "paper"], "a machine of its own"),
        (["identify", "bring-up", "--log", "x.csv", "--mistake", "delay-2"], "is judged alone"),
        (["evaluate", "--policy", __file__], "is no .json file that tune wrote"),
        (["replay", "sample", "--angle", "inf"], "angle"),
        (["replay", "sample", "--speed", "1e9"], "speed"),
        (["train", "--name", "x", "--gamma", "2"], "gamma"),
        (["simulate", "--scenario", "hold:1:0", "--start"], "start, scenario: a scenario has its"),
        (["simulate", "--scenario", "hold:1:0", "--duration", "3.0"], "duration, scenario"),
        (["simulate", "--plant", "a.json", "--log", "b"], "log, plant: a machine alone has no"),
        (["simulate", "--show", "faults"], "show: there is no picture; give --plot"),
        (["simulate", "--set", "speed_hz=4", "--set", "speed_hz=5"], "set: speed_hz: given twice"),
        (["evaluate", "--suite", "stress", "--suite", "stress-1"], "--suite: given twice"),
        (["train", "--name", "x", "--steps", "9", "--minutes", "1"], "steps, minutes: 9 and 1"),
        (["train", "--resume", ".", "--steps", "9", "--minutes", "1"], "steps, minutes: 9 and 1"),
        (["train", "--name", "x", "--minutes", "0"], "minutes, steps: 0 and 0"),
        (["train", "--name", "x", "--batch-size", "200000"], "batch_size: 200000: an update has"),
        (["train", "--name", "x", "--axes", "speed"], "axes"),
        (["train", "--name", "x", "--start", "linear:110,320", "--axes", "speed:0:1:4"], "start"),
        (["train", "--resume", "nothing"], "resume: there is no folder 'nothing'"),
        (["report", "runs/none"], "policy: there is no folder 'runs/none'; give"),
        (["replay", "nope.mat"], "'nope.mat': No such file or directory; give"),
        (["motor", "import-map", "nope.mat", "--motor", "paper"], "nope.mat: No such file"),
    ],
)
def test_a_mistake_is_one_line(words: list[str], said: str, tmp_path: Path) -> None:
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert len(done.stderr.strip().splitlines()) == 1
    assert said in done.stderr
    assert not list(tmp_path.iterdir()), "nothing half-written"


@pytest.mark.parametrize(
    ("words", "value"),
    [
        ("simulate --seed -1", "'-1'"),
        ("evaluate --policy eq25 --size 1e9", "'1e9'"),
        ("motor new --l 0.4mH --name a --out a.toml", "'0.4mH'"),
        ("replay sample --after nan", "'nan'"),
    ],
)
def test_a_value_of_the_wrong_type_is_named(words: str, value: str, tmp_path: Path) -> None:
    """With its option, by every version of the library."""
    done = run(*words.split(), cwd=tmp_path)
    assert done.returncode == 2 and value.strip("'") in done.stderr


def test_a_run_to_resume_is_looked_for_below_runs(tmp_path: Path) -> None:
    (tmp_path / "runs" / "k3").mkdir(parents=True)
    done = run("train", "--resume", "k3", cwd=tmp_path)
    assert done.returncode == 2 and "did you mean runs/k3?" in done.stderr


@pytest.mark.usefixtures("all_draws")
def test_evaluation_is_the_same_file_to_the_bit(tmp_path: Path) -> None:
    """Also from another process."""
    words = ["evaluate", "--policy", "eq25", "--policy", "hysteresis", "--suite", "stress-1"]
    for name, seed, start in (("a.json", "7", run), ("b.json", "7", process), ("c.json", "8", run)):
        done = start(*words, "--seed", seed, "--size", "6", "--out", name, cwd=tmp_path)
        assert done.returncode == 0, done.stderr
    a, b, c = ((tmp_path / f"{name}.json").read_bytes() for name in "abc")
    assert a == b != c
    results = json.loads(a)
    assert (results["suite"], results["seed"], results["size"]) == ("stress-1", 7, 6)
    eq25 = results["policies"]["eq25"]
    names = ("torque_dev_rms", "torque_ripple_rms", "overshoot_pct", "angle_err_rms_deg")
    assert all(isinstance(eq25[name], float) for name in ("lost_rate", *names))
    assert len(eq25["lost_ci"]) == 2
    assert all(len(eq25["scenarios"][name]) == 6 for name in ("lost", "seed", *names))
    other = json.loads(c)["policies"]["eq25"]["scenarios"]["seed"]
    assert not set(other) & set(eq25["scenarios"]["seed"])


def test_without_a_plan_every_motor_gets_the_same_shares_of_its_speed() -> None:
    from sensorless.envs.scenarios.words import fig9
    from sensorless.machine.motor import Motor

    motor = Motor.load("paper")
    assert fig9(motor) == "0:200,1:350,2:600"
    assert fig9(replace(motor, n_rated_rpm=6000.0)) == "0:800,1:1400,2:2400"
    assert fig9(replace(motor, n_rated_rpm=150.0)) == "0:20,1:35,2:60"


def test_fig9_meets_its_figures(tmp_path: Path) -> None:
    """Fig. 9 of the source paper: k_s 1, about 0.5, 0; settled within 0.5 s; error below 5 deg."""
    from sensorless.design.drive import DriveDesign
    from sensorless.envs.scenarios.words import plan_from
    from sensorless.evaluation.trace import trace
    from sensorless.evaluation.trace_summary import plateaus
    from sensorless.machine.motor import Motor
    from sensorless.policies.registry import make_policy

    motor = Motor.load("paper")
    for seed in range(4):
        plan = plan_from("0:200,1:350,2:600", "0:0", None, 3.0, motor, seed)
        rows = plateaus(trace(make_policy("eq25", motor), plan, motor, DriveDesign()))
        assert [round(row["target_rpm"]) for row in rows] == [200, 350, 600]
        assert rows[0]["k_s"] == 1.0
        assert rows[1]["k_s"] == pytest.approx(0.5, abs=0.03)
        assert rows[2]["k_s"] == 0.0
        assert all(row["settled_s"] <= 0.5 for row in rows)
        assert all(row["overshoot_pct"] <= 2.0 for row in rows)
        assert all(row["angle_err_steady_deg"] < 5.0 for row in rows)


def test_simulate_starts_from_the_wrong_pole(tmp_path: Path) -> None:
    """The rotor is found in the 33 ms of the sequence; without it the same drive gets lost."""
    words = ["simulate", "--theta-err", "180", "--speed", "0:0,0.1:300", "--duration", "0.4"]
    found = run(*words, "--start", "--plot", "run.png", "--out", "run.csv", cwd=tmp_path)
    assert found.returncode == 0, found.stderr
    assert "kept lock, rotor found after 33 ms" in " ".join(found.stdout.split())
    assert "[s]" in found.stdout and "[r/min]" in found.stdout
    header, *rows = (tmp_path / "run.csv").read_text().splitlines()
    starting = [float(row.split(",")[header.split(",").index("starting")]) for row in rows]
    assert starting == [1.0] * 167 + [0.0] * (2000 - 167)
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")
    assert "lost (angle)" in run(*words, cwd=tmp_path).stdout


def test_simulate_writes_csv_and_picture(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    words = ["simulate", "--duration", "0.3", "--out", "run.csv", "--plot", "run.png"]
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    lines = (tmp_path / "run.csv").read_text().splitlines()
    assert lines[0].startswith("t,omega_m_ref,omega_m")
    assert len(lines) == 1501
    assert (tmp_path / "run.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.skipif(sys.platform != "linux", reason="other systems have no such file names")
def test_a_policy_whose_file_name_is_not_utf8_has_a_picture(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    name = os.fsdecode(b"lauf\xdf.json")
    (tmp_path / name).write_bytes((FOLDER / "tuned" / "linear-tuned.json").read_bytes())
    done = run("simulate", "--duration", "0.1", "--policy", name, "--plot", "x.png", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "x.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    "words",
    [
        ("evaluate", "--policy", "fuzzy-coupled-tuned", "--size", "3"),
        ("simulate", "--duration", "0.1"),
        ("settings",),
        ("motors",),
    ],
)
def test_a_narrow_terminal_shows_all(
    words: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rich shortens with an ellipsis what does not fit."""
    monkeypatch.setenv("COLUMNS", "60")
    done = process(*words, cwd=tmp_path)
    assert done.returncode == 0 and "…" not in done.stdout


def test_plant_alone_writes_the_format_of_the_golden_files(tmp_path: Path) -> None:
    case = GOLDEN / "linear_injection"
    words = ["simulate", "--plant", f"{case}.json", "--inputs", f"{case}.u.csv", "--out", "y.csv"]
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    header = (tmp_path / "y.csv").read_text().splitlines()[0]
    assert header == "t,i_d,i_q,i_alpha,i_beta,i_a,i_b,i_c,psi_d,psi_q,tau_M,w_M,theta_m"
