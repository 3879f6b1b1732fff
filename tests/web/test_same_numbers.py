"""One case, the same numbers wherever a user reads them, to the precision that is printed.

What the target computes is compared in ``tests/pil``, whole pages of results in ``tests/docs``.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.helpers.command import run
from tests.web.conftest import Shown
from tests.web.native import Move
from tests.web.test_playground import LEVERS, link, repeat

SPEEDS = {0.0: 200.0, 1.0: 350.0, 2.0: 600.0}
"""Reference [r/min] from each instant [s] on, without load: the steps of the paper's Fig. 9."""
DURATION = 2.5


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("desk")


def read(desk: Path, command: str) -> Any:
    """What a command prints for programs."""
    done = run(*command.split(), "--json", cwd=desk)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def simulated(desk: Path) -> Any:
    told = ",".join(f"{t:g}:{n:g}" for t, n in SPEEDS.items())
    where = "--out run.csv --log log.csv"
    return read(desk, f"simulate --speed {told} --load 0:0 --duration {DURATION} {where}")


@pytest.mark.usefixtures("without_ekf")
def test_replay_of_the_log_says_what_simulate_said(desk: Path, simulated: Any) -> None:
    """Of the blend; the Kalman filter beside it has no say."""
    found = read(desk, "replay log.csv --policy eq25")["estimators"]["blend"]
    largest = max(plateau["angle_err_max_deg"] for plateau in simulated["plateaus"])
    assert f"{found['max_deg']:.1f}" == f"{largest:.1f}"
    rows = np.genfromtxt(desk / "run.csv", delimiter=",", names=True)
    errors = np.rad2deg(rows["theta_e_err"])
    assert found["mean_deg"] == pytest.approx(float(errors.mean()), abs=5e-3)


def test_the_playground_shows_what_simulate_said(shown: Shown, desk: Path, simulated: Any) -> None:
    (first, *_), (_, *later) = SPEEDS.values(), SPEEDS.items()
    plain = dict.fromkeys(LEVERS, 100.0) | {"ramp": 0.0, "load": 0.0, "offset": 0.0}
    moves: list[Move] = [(round(1e3 * t), "speed", n) for t, n in later]
    decisions = round(1e3 * DURATION)
    told = link("paper", ["coupled eq25"], plain | {"speed": first}, moves, decisions)
    shown.driver.get(shown.file.as_uri())
    repeat(shown, told, decisions)
    for _ in range(7):  # the page writes its numbers anew every sixth picture
        shown.driver.execute_async_script("requestAnimationFrame(arguments[0])")
    cells = shown.run(
        "return [...document.querySelectorAll('#now tbody tr')]"
        ".map((row) => row.cells[1].textContent.replace('−', '-'))"
    )
    rows = np.genfromtxt(desk / "run.csv", delimiter=",", names=True)
    last = rows[-1]
    largest = max(plateau["angle_err_max_deg"] for plateau in simulated["plateaus"])
    lately = rows[rows["t"] >= DURATION - 0.01]["omega_m"] * 30.0 / np.pi
    assert cells[0] in {f"{rpm:.0f}" for rpm in lately}, "of the last picture, before the last row"
    assert cells[3] == f"{largest:.1f}"
    assert cells[4] == f"{last['k_s']:.2f}"


def test_a_report_says_what_evaluate_and_simulate_say(desk: Path) -> None:
    drawn = "--suite stress-1 --seed 7 --size 4"
    read(desk, f"report linear:100,700 --policy eq25 {drawn} --grid 2 --out report")
    told = read(desk, f"evaluate --policy linear:100,700 --policy eq25 {drawn}")
    page = (desk / "report" / "index.html").read_text(encoding="utf-8")
    for name, policy in told["policies"].items():
        assert f">{100.0 * policy['torque_dev_rms']:.2f}<" in page, name
    worst = told["policies"]["linear:100,700"]["worst"][0]
    replayed = read(desk, f"simulate --scenario {worst['scenario']} --policy linear:100,700")
    largest = max(plateau["angle_err_max_deg"] for plateau in replayed["plateaus"])
    assert f"{largest:.1f}" == f"{worst['angle_err_max_deg']:.1f}"
    assert f">{worst['scenario']}</button>" in page and f">{largest:.1f}</td>" in page
