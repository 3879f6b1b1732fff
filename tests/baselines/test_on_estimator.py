"""Rules that bring their own estimator get it, wherever they are run."""

from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.design.records import bring_up_record, control_record
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.rollout import rollout
from sensorless.evaluation.trace import trace
from sensorless.export.code import params_source
from sensorless.machine.motor import Motor
from sensorless.policies.registry import RULES, make_policy
from sensorless.policies.tuned import Tuned
from sensorless.policy import design_for
from sensorless.table.ks_table import KsTable
from sensorless.tuning.batch import SideBySide

pytestmark = pytest.mark.usefixtures("short_suites")

PAPER = Motor.load("paper")


@pytest.mark.parametrize(
    ("name", "estimator"),
    [("sliding_mode", "smo"), ("error_blend", "errors"), ("flux_observer", "flux")],
)
def test_it_is_eq25_on_that_design(name: str, estimator: str) -> None:
    """The same to the bit, and not the same as Eq. 25 on the design's own estimator."""
    policy, eq25 = make_policy(name, PAPER), make_policy("eq25", PAPER)
    assert policy.settings == {"estimator": estimator} and not eq25.settings
    scenarios = suite("stress-1", PAPER, 3, 4)
    own, other = (
        SimFactory(PAPER, DriveDesign()),
        SimFactory(PAPER, DriveDesign(estimator=estimator)),
    )
    asked = rollout(policy, scenarios, own).sums
    assert asked.tobytes() == rollout(eq25, scenarios, other).sums.tobytes()
    assert asked.tobytes() != rollout(eq25, scenarios, own).sums.tobytes()


def test_a_trace_has_it_too() -> None:
    scenario = suite("paper", PAPER, 0, 1)
    asked = trace(make_policy("flux_observer", PAPER), scenario, PAPER, DriveDesign())
    other = trace(make_policy("eq25", PAPER), scenario, PAPER, DriveDesign(estimator="flux"))
    np.testing.assert_array_equal(asked["theta_e_err"], other["theta_e_err"])


def test_side_by_side_is_one_estimator() -> None:
    flux = make_policy("flux_observer", PAPER)
    assert SideBySide([flux, flux]).settings == {"estimator": "flux"}
    with pytest.raises(ValueError, match="different drives"):
        SideBySide([flux, make_policy("eq25", PAPER)])


def test_a_rule_keeps_its_own(tmp_path: Path) -> None:
    """Whatever it was tuned on; a rule that has none gets that of its file."""
    for rule, estimator in (("flux_observer", "flux"), ("linear", "errors")):
        path = tmp_path / f"{rule}.json"
        provenance = {"design": {"estimator": "errors"}}
        Tuned(rule, RULES[rule].defaults(), provenance).save(path)
        policy = make_policy(str(path), PAPER)
        assert design_for(policy, DriveDesign()).estimator == estimator


@pytest.mark.usefixtures("without_selftest")
def test_it_is_exported_with_it(tmp_path: Path) -> None:
    """Table and estimator go together to firmware."""
    out = tmp_path / "out"
    words = ["export", "flux_observer", "--out", str(out), "--no-fit"]
    answer = CliRunner().invoke(app, words)
    assert answer.exit_code == 0, answer.output
    known = KsTable.load(out / "ks_table.json").provenance
    assert known["design"]["estimator"] == "flux"
    want = params_source(
        control_record(PAPER, DriveDesign(estimator="flux")),
        bring_up_record(PAPER),
        KsTable.load(out / "ks_table.json").rule,
        decision_periods(PAPER),
    )
    assert (out / "params.c").read_text() == want
