"""The leaderboard: its file has policies on the frozen suites, its page is made from the file."""

import pytest
from scipy.stats import beta

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.frozen import FROZEN, MOTOR, SEED, Frozen
from sensorless.evaluation.evaluate import evaluate
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policies
from tests.helpers.script import script

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


def test_a_row_is_what_evaluate_says() -> None:
    small = Frozen("low-inertia", 6, "")
    row = STUDY.judged("sliding_mode", small)
    motor = Motor.load(MOTOR)
    policies = make_policies(["sliding_mode"], motor)
    said = evaluate(motor, DriveDesign(), small.suite, SEED, 6, policies).policies["sliding_mode"]
    lost = int(row["lost"])
    assert 0 < lost == round(6 * said["lost_rate"]) < 6
    assert float(row["lost_low"]) == pytest.approx(beta.ppf(0.025, lost, 7 - lost), rel=1e-4)
    for name, *_ in STUDY.COLUMNS:
        assert float(row[name]) == pytest.approx(said[name], rel=1e-5, nan_ok=True), name
    assert (row["estimator"], row["bound"]) == ("smo", "0")
