"""The leaderboard: its file has policies on the frozen suites, its page is made from the file."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import beta

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.frozen import FROZEN, MOTOR, SEED, Frozen
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import evaluate
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policies
from tests.helpers.script import script

pytestmark = pytest.mark.usefixtures("short_suites")

STUDY = script("studies/leaderboard.py")
ROWS = STUDY.read(STUDY.CSV)


def test_every_policy_stands_there_on_every_suite() -> None:
    found = {(row["suite"], row["digest"], row["policy"]) for row in ROWS}
    names = {row["policy"] for row in ROWS}
    assert len(found) == len(ROWS) == len(FROZEN) * len(names)
    assert found == {(f.suite, f.digest, name) for f in FROZEN for name in names}
    assert {*STUDY.PLAIN, "reference", "reference-flux", "logistic-tuned"} <= names
    assert {*STUDY.PLAIN, "reference"} <= set(STUDY.shipped_words())


def test_the_page_is_that_of_the_file() -> None:
    assert STUDY.page(ROWS) == STUDY.PAGE.read_text(encoding="utf-8")
    assert STUDY.text_of(STUDY.ordered(ROWS)) == STUDY.CSV.read_text(encoding="utf-8")


def test_the_errors_by_scenario_are_those_of_the_file() -> None:
    each = STUDY.kept_each(STUDY.EACH)
    rows = [row for row in ROWS if row["suite"] == STUDY.FIRST]
    assert set(each) == {row["policy"] for row in rows}
    for row in rows:
        x = each[row["policy"]].astype(float)
        kept = x[:, 0] != STUDY.LOST
        assert int(row["feasible"]) - int(row["lost"]) == kept.sum()
        means = STUDY.STEP * x[kept].mean(axis=0)
        wanted = [float(row[name]) for name in ("torque_dev_rms", "torque_ripple_rms")]
        assert means == pytest.approx(wanted, abs=STUDY.STEP)


def test_two_policies_are_compared_where_both_survive() -> None:
    there = np.full((50, 2), [2000, 1000], dtype=np.uint16)
    here = there - np.array([20, 0], dtype=np.uint16)
    here[3], there[4] = STUDY.LOST, STUDY.LOST
    text = STUDY.pair("mine", "theirs", {"mine": here, "theirs": there})
    assert text.splitlines() == [
        "mine beside theirs, stress-1: lost 1 and 1",
        "torque deviation: -1.00 % (-1.00 to -1.00 %)",
        "torque ripple: +0.00 % (+0.00 to +0.00 %)",
    ]


def test_a_row_is_what_evaluate_says() -> None:
    small = Frozen("low-inertia", 6, "")
    row, each = STUDY.judged("sliding_mode", small)
    motor = Motor.load(MOTOR)
    policies = make_policies(["sliding_mode"], motor)
    said = evaluate(motor, DriveDesign(), small.suite, SEED, 6, policies).policies["sliding_mode"]
    lost = int(row["lost"])
    assert 0 < lost == round(6 * said["lost_rate"]) < 6
    assert float(row["lost_low"]) == pytest.approx(beta.ppf(0.025, lost, 7 - lost), rel=1e-4)
    for name, *_ in STUDY.COLUMNS:
        assert float(row[name]) == pytest.approx(said[name], rel=1e-5, nan_ok=True), name
    assert (row["estimator"], row["bound"]) == ("smo", "0")
    ripple = np.array(said["scenarios"]["torque_ripple_rms"])
    survived = ~np.array(said["scenarios"]["lost"])
    assert STUDY.STEP * each[survived, 1] == pytest.approx(ripple[survived], abs=STUDY.STEP)
    assert (each[~survived] == STUDY.LOST).all()


def test_an_interrupted_run_keeps_the_rows_of_others(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At the end, and only then, rows of policies that do not ship any more go."""
    for name, file in (("CSV", "a.csv"), ("EACH", "a.npz"), ("PAGE", "a.md")):
        shutil.copy(getattr(STUDY, name), tmp_path / file)
        monkeypatch.setattr(STUDY, name, tmp_path / file)
    old = {(row["suite"], row["policy"]): row for row in ROWS}
    each = STUDY.kept_each(STUDY.EACH)

    def judged(word: str, frozen: Frozen) -> tuple[dict[str, str], object]:
        if word == "stop":
            raise KeyboardInterrupt
        return old[frozen.suite, word], each[word]

    monkeypatch.setattr(STUDY, "judged", judged)
    with pytest.raises(KeyboardInterrupt):
        STUDY.judge_all(["eq25", "stop"], drop_others=True)
    assert STUDY.read(STUDY.CSV) == ROWS and set(STUDY.kept_each(STUDY.EACH)) == set(each)
    STUDY.judge_all(["eq25", "reference"], drop_others=True)
    assert {row["policy"] for row in STUDY.read(STUDY.CSV)} == {"eq25", "reference"}
    assert set(STUDY.kept_each(STUDY.EACH)) == {"eq25", "reference"}


@pytest.mark.parametrize(
    ("body", "why"),
    [
        ("settings = {'speed_hz': 0.5}", "settings: they change the control"),
        ("name = 'reference'", "'reference' ships; give it one of its own"),
        ("settings = {'estimator': 'smo'}", None),
    ],
)
def test_a_policy_that_moves_the_yardstick_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, body: str, why: str | None
) -> None:
    """A lazy speed loop would win, since its twin is as lazy."""
    module = f"own_{len(body)}"
    lines = ["import numpy as np", "class Own:", f"    {body}"]
    lines += ["    def __init__(self, motor):", "        pass"]
    lines += ["    def act(self, obs):", "        return np.ones(len(obs), np.float32)"]
    (tmp_path / f"{module}.py").write_text("\n".join(lines))
    monkeypatch.syspath_prepend(tmp_path)
    if why is None:
        assert STUDY.admitted(f"{module}:Own")[1].name == "Own"
        return
    with pytest.raises(UserError, match=why):
        STUDY.admitted(f"{module}:Own")
