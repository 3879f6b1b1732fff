"""Certificates count what ``evaluate`` counts, stop and go on, and know their run."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.core.api import SIM
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.errors import UserError
from sensorless.evaluation import certify as module
from sensorless.evaluation.certificate import Tally, exact_interval, read_tally, result, write
from sensorless.evaluation.certify import certify, certify_machines
from sensorless.evaluation.evaluate import evaluate
from sensorless.evaluation.machines import evaluate_machines
from sensorless.evaluation.rollout import CAUSES, Rollout
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import Policy

pytestmark = pytest.mark.usefixtures("short_suites")

PAPER, SMO = Motor.load("paper"), DriveDesign(estimator="smo")
SUITE, SEED = "unload", 21
"""Eq. 25 on the SMO loses some of these."""


def test_the_exact_interval() -> None:
    """Beta quantiles of Clopper and Pearson; none of n: 1 - 0.025^(1/n)."""
    most = exact_interval(0, 1_000_000)[1]
    assert most == pytest.approx(1.0 - 0.025**1e-6) and most < 3.7e-6
    assert exact_interval(2, 10) == pytest.approx((0.0252, 0.5561), abs=1e-4)  # table value
    assert exact_interval(0, 0) == (0.0, 1.0)


def test_rates_are_of_the_feasible_scenarios() -> None:
    """100 less 40."""
    run = {"suite": SUITE, "seed": SEED}
    found = result(run, Tally(100, 40, 3, 2, (1, 2, 3), (4, 5)))
    assert found["lost_ci"] == exact_interval(3, 60)
    assert found["not_held_ci"] == exact_interval(2, 60)


def test_what_is_not_feasible_is_neither_lost_nor_held(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four scenarios, twice: not held, lost, lost with the twin, not held."""
    lost = np.array([0, CAUSES["angle"], CAUSES["angle"] | CAUSES["twin"], 0], dtype=np.int32)
    four = Scenarios.nominal(PAPER, np.ones(4, dtype=np.uint64), 1.0)
    sums = np.zeros((1, 4), dtype=SIM["sums"])

    def made_up(*of: object, **more: object) -> list[Rollout]:
        return [Rollout(PAPER, four, sums, lost, np.ones(4, dtype=np.int64))]

    monkeypatch.setattr(module, "CHUNK", 4)
    monkeypatch.setattr(module, "rollouts", made_up)
    monkeypatch.setattr(module, "with_twin_to_the_end", lambda r, *of: r)
    monkeypatch.setattr(module, "not_held", lambda r: np.array([1.0, 0.0, 1.0, 1.0]))
    found = certify(make_policy("eq25", PAPER), PAPER, SMO, SUITE, SEED, 8)
    assert [found[x] for x in ("scenarios", "infeasible", "lost", "not_held")] == [8, 2, 2, 4]
    assert found["first_lost"] == [f"{SUITE}:{SEED}:{i}" for i in (1, 5)]
    assert found["first_not_held"] == [f"{SUITE}:{SEED}:{i}" for i in (0, 3, 4, 7)]


def test_it_counts_as_evaluate_does_and_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """In two parts and on threads the same file as in one; memory of a rule does no harm."""
    monkeypatch.setenv("SENSORLESS_THREADS", "2")
    rule, size, parts, whole = "hysteresis", 96, tmp_path / "parts.json", tmp_path / "whole.json"
    for n in (40, size):
        certify(make_policy(rule, PAPER), PAPER, SMO, SUITE, SEED, n, out=parts)
    policy = make_policy(rule, PAPER)
    monkeypatch.setenv("SENSORLESS_THREADS", "1")
    found = certify(policy, PAPER, SMO, SUITE, SEED, size, out=whole)
    assert parts.read_bytes() == whole.read_bytes()
    judged = evaluate(PAPER, SMO, SUITE, SEED, size, {rule: policy}).policies[rule]
    lost = np.flatnonzero(judged["scenarios"]["lost"])
    assert 0 < found["lost"] == len(lost) and found["scenarios"] == size
    assert found["first_lost"] == [f"{SUITE}:{SEED}:{i}" for i in lost]
    kept = size - len(lost) - found["infeasible"]
    assert found["not_held"] == pytest.approx(kept * judged["not_held"])


def test_machines_count_as_evaluate_does_and_go_on_within_one(tmp_path: Path) -> None:
    design, parts = DriveDesign(estimator="smo"), tmp_path / "parts.json"

    def rule(motor: Motor) -> Policy:
        return make_policy("linear:150,450", motor)

    for n in (20, 48):
        found = certify_machines(rule, design, 5, n, out=parts)
    judged = evaluate_machines(design, 5, 3, lambda motor: {"rule": rule(motor)})
    lost = np.flatnonzero(judged.policies["rule"]["scenarios"]["lost"])
    assert 0 < found["lost"] == len(lost) and found["scenarios"] == 48
    assert found["first_lost"] == [f"machines:5:{i}" for i in lost]
    with pytest.raises(UserError, match="of another"):
        certify(rule(PAPER), PAPER, design, SUITE, 5, 48, out=parts)


def test_a_file_knows_its_run(tmp_path: Path) -> None:
    out = tmp_path / "c.json"
    certify(make_policy("eq25", PAPER), PAPER, SMO, SUITE, SEED, 4, out=out)
    before = out.read_bytes()
    for rule, design, seed, size, said in (
        ("fuzzy", SMO, SEED, 8, "policy"),
        ("eq25", DriveDesign(), SEED, 8, "design"),
        ("eq25", SMO, 1, 8, "seed"),
        ("eq25", SMO, SEED, 3, "has 4 scenarios"),
    ):
        with pytest.raises(UserError, match=said):
            certify(make_policy(rule, PAPER), PAPER, design, SUITE, seed, size, out=out)
        assert out.read_bytes() == before
    out.write_text("{}", encoding="utf-8")
    with pytest.raises(UserError, match="not a file of"):
        certify(make_policy("eq25", PAPER), PAPER, SMO, SUITE, SEED, 8, out=out)


@pytest.mark.parametrize(
    "damage",
    [
        {"scenarios": "4"},
        {"infeasible": None},
        {"lost": 1.5},
        {"not_held": -1},
        {"not_held_at": [math.nan]},
        {"lost": 3, "lost_at": [0, 1, 2], "not_held": 2, "not_held_at": [0, 1]},
        {"lost": 1, "lost_at": [4]},
        {"lost": 1, "lost_at": []},
        {"lost": 2, "lost_at": [2, 1]},
        {"lost": 2, "lost_at": [1, 1]},
        {"not_held": 2, "not_held_at": [3, 0]},
    ],
)
def test_a_damaged_tally_is_refused(damage: dict[str, object], tmp_path: Path) -> None:
    """It would count in the rates."""
    out = tmp_path / "c.json"
    write(out, {"suite": SUITE, "seed": SEED}, Tally(scenarios=4))
    assert read_tally(out, {}) == Tally(scenarios=4)
    known = json.loads(out.read_text())
    known["tally"] |= damage
    out.write_text(json.dumps(known))
    with pytest.raises(UserError, match="not a file of sensorless certify"):
        read_tally(out, {})


def test_what_knows_the_truth_is_not_certified() -> None:
    with pytest.raises(UserError, match="knows the truth"):
        certify(make_policy("sensored", PAPER), PAPER, SMO, SUITE, SEED, 4)


def test_lists_stay_short() -> None:
    many = Tally(90, 0, 90, 0, tuple(range(90))) + Tally(90, 0, 90, 0, tuple(range(90, 180)))
    assert many.lost == 180 and many.lost_at == tuple(range(100))


def test_the_command_says_what_it_found(tmp_path: Path) -> None:
    out = tmp_path / "c.json"
    done = CliRunner().invoke(app, ["certify", "eq25", "--size", "8", "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert "lost: 0 of 8, 0 to 37 % (95 %" in done.stdout
    assert json.loads(out.read_text(encoding="utf-8"))["lost_ci"][1] == pytest.approx(
        0.369, abs=1e-3
    )
