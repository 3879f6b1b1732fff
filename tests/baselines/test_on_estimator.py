"""Rules that bring their own estimator get it, wherever they are run."""

import numpy as np
import pytest

from sensorless.baselines.registry import make_policy
from sensorless.drive import DriveDesign
from sensorless.envs.policy import estimator_of
from sensorless.envs.scenario import SimFactory
from sensorless.errors import UserError
from sensorless.export import table_of
from sensorless.motor import Motor
from sensorless.rollout import rollout
from sensorless.suites import suite
from sensorless.trace import trace
from sensorless.tuning_batch import SideBySide

PAPER = Motor.load("paper")


@pytest.mark.parametrize(
    ("name", "estimator"), [("error_blend", "errors"), ("flux_observer", "flux")]
)
def test_it_is_eq25_on_that_design(name: str, estimator: str) -> None:
    """The same to the bit, and not the same as Eq. 25 on the design's own estimator."""
    policy, eq25 = make_policy(name, PAPER), make_policy("eq25", PAPER)
    assert estimator_of(policy) == estimator and estimator_of(eq25) is None
    scenarios = suite("stress", PAPER, 3, 4)
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
    assert estimator_of(SideBySide([flux, flux])) == "flux"
    with pytest.raises(ValueError, match="unpack"):
        SideBySide([flux, make_policy("eq25", PAPER)])


def test_its_table_alone_is_not_exported() -> None:
    with pytest.raises(UserError, match="no table"):
        table_of(make_policy("flux_observer", PAPER), "flux_observer")
