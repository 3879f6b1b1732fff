"""``make reference`` with a stand-in for ``sensorless``: what is called, and what is not again."""

import shutil
import subprocess
from pathlib import Path

import pytest

from sensorless.policies.registry import RULES

ROOT = Path(__file__).parents[2]
MAKEFILE = ROOT / "results" / "reference.mk"

STAND_IN = """#!/bin/sh
echo "$@" >> "$LOG"
case $1 in
tune) while [ "$1" != --out ]; do shift; done; echo tuned > "$2";;
train)
    [ ! -e "runs/$3" ] || { echo "runs/$3 exists" >&2; exit 2; }
    mkdir -p "runs/$3"; cd "runs/$3" || exit
    echo "$5" > table.json; echo {} > config.json
    printf 'steps,seconds,lost_rate,torque_dev,torque_ripple,objective,best\\n' > progress.csv
    printf '1,1,0.1,0.1,0.1,0.9,1\\n2,2,0.1,0.1,0.1,0.%s,1\\n' "$((5 - $5))" >> progress.csv
    [ -z "$BREAK" ] || exit 130;;
report) mkdir -p "$2/report"; echo page > "$2/report/index.html";;
studies/*.py) ;;
esac
"""

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    script = tmp_path / "stand-in"
    script.write_text(STAND_IN)
    script.chmod(0o755)
    return tmp_path


def make(folder: Path, *, stop: bool = False) -> tuple[int, list[str]]:
    """Exit status and the calls of one ``make reference``."""
    log = folder / "log"
    log.write_text("")
    words = {
        "SENSORLESS": folder / "stand-in",
        "PYTHON": folder / "stand-in",
        "OUT": folder / "out",
        "SHIPPED": folder / "shipped",
        "WORK": folder / "work",
        "RULES": "linear gated",
        "SEEDS": "1 2 3",
    }
    done = subprocess.run(
        ["make", "-f", str(MAKEFILE), *(f"{name}={value}" for name, value in words.items())],
        cwd=ROOT,
        env={"PATH": "/usr/bin:/bin", "LOG": str(log), "BREAK": "1" if stop else ""},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, log.read_text().splitlines()


def test_all_of_it_once(folder: Path) -> None:
    status, calls = make(folder)
    assert status == 0
    tuned = {" ".join(call.split()[1:]) for call in calls if call.startswith("tune")}
    where = f"--budget 50000 --set estimator=coupled --out {folder}/out/tuned"
    assert tuned == {f"{r} {where}/{r}-coupled-tuned.json" for r in ("linear", "gated")}
    trained = sorted(call for call in calls if call.startswith("train"))
    length = "--steps 10000000 --set estimator=coupled"
    assert trained == [f"train --name run --seed {seed} {length}" for seed in "123"]
    suites = "--suite stress-1 --suite handoff --suite stress"
    publish = f"studies/publish_reference.py {folder}/out {folder}/shipped {suites}"
    board = "studies/leaderboard.py"
    assert calls[-2:] == [publish, board]
    del calls[-2:]
    assert calls[-1].startswith(f"report {folder}/out --size 2000")
    assert suites in calls[-1]
    tuned_rule = f"{folder}/out/tuned/gated-coupled-tuned.json"
    for policy in ("sliding_mode", "eq25", "logistic-tuned", tuned_rule, f"{folder}/out/seed-2"):
        assert f"--policy {policy} " in calls[-1]
    assert (folder / "out" / "table.json").read_text() == "3\n", "the best in validation"
    assert make(folder) == (0, [publish, board]), "what is there is kept"


def test_an_interrupted_training_starts_again_and_the_rest_stays(folder: Path) -> None:
    status, calls = make(folder, stop=True)
    assert status != 0 and calls
    assert not list((folder / "out").rglob("table.json"))
    assert make(folder)[0] == 0
    (folder / "out" / "seed-2" / "table.json").unlink()
    status, calls = make(folder)
    assert [call.split()[0] for call in calls[:-2]] == ["train", "report"]
    assert "--seed 2 " in calls[0]


def test_its_rules_are_rules() -> None:
    (line,) = [x for x in MAKEFILE.read_text().splitlines() if x.startswith("RULES")]
    names = line.split("?=")[1].split()
    assert len(names) >= 5
    assert all(RULES[name].parameters for name in names)
