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
studies/publish_reference.py) ;;
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
        "FLUX_RULES": "logistic",
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
    flux = f"logistic --budget 50000 --set estimator=flux --out {folder}/out/tuned"
    rules = {
        f"{r} --budget 50000 --out {folder}/out/tuned/{r}-tuned.json" for r in ("linear", "gated")
    }
    assert tuned == {*rules, f"{flux}/logistic-flux-tuned.json"}
    trained = [call.split("--seed ")[1] for call in calls if call.startswith("train")]
    assert len(trained) == 9
    for seed in "123":
        fresh, refined, smo = sorted(call for call in trained if call.startswith(seed))
        assert fresh.endswith("--set estimator=flux")
        assert "--set estimator=flux --start logistic-flux-tuned.json --axes start" in refined
        assert "--start linear-tuned.json --axes speed:16," in smo
    publish = f"studies/publish_reference.py {folder}/out {folder}/shipped"
    assert calls.pop() == publish
    assert calls[-1].startswith(f"report {folder}/out --size 2000")
    for policy in ("eq25", f"{folder}/out/tuned/gated-tuned.json", f"{folder}/out/seed-2"):
        assert f"--policy {policy} " in calls[-1]
    assert (folder / "out" / "table.json").read_text() == "3\n", "the best in validation"
    assert make(folder) == (0, [publish]), "what is there is kept"


def test_an_interrupted_training_starts_again_and_the_rest_stays(folder: Path) -> None:
    status, calls = make(folder, stop=True)
    assert status != 0 and calls
    assert not list((folder / "out").rglob("table.json"))
    assert make(folder)[0] == 0
    (folder / "out" / "seed-2" / "table.json").unlink()
    status, calls = make(folder)
    assert [call.split()[0] for call in calls[:-1]] == ["train", "report"]
    assert "--seed 2 " in calls[0] and "logistic-flux-tuned.json" in calls[0]


def test_its_rules_are_rules() -> None:
    text = MAKEFILE.read_text().replace("\\\n", " ")
    lines = [x for x in text.splitlines() if x.startswith(("RULES", "FLUX_RULES"))]
    names = [name for line in lines for name in line.split("?=")[1].split()]
    assert len(lines) == 2 and len(names) > 15
    assert all(RULES[name].parameters for name in names)
