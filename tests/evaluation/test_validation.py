"""What validation counts."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import member
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.aggregate import summary
from sensorless.evaluation.metrics.catalogue import torque_dev_rms
from sensorless.evaluation.rollout import rollout, with_twin_to_the_end
from sensorless.evaluation.validation import SUITE, validate
from sensorless.policies.registry import make_policy
from sensorless.tuning.batch import costs


def test_a_scenario_beyond_the_machine_is_nobodys_loss() -> None:
    """As ``evaluate`` counts: here the sensored twin fails in some, and the policy in no other."""
    motor = member(1000001, 2)
    motor = replace(motor, i_trip=1.04 * motor.i_max)
    factory, policy = SimFactory(motor, DriveDesign()), make_policy("eq25", motor)
    scenarios = suite(SUITE, motor, 0, 256, role="tune")
    found = validate(policy, factory, 256)
    r = with_twin_to_the_end(rollout(policy, scenarios, factory), factory)
    judged = summary(r.lost, {"torque_dev_rms": torque_dev_rms(r)}, 0)
    assert judged["infeasible_rate"] > 0.0 and np.mean(r.lost != 0) > judged["lost_rate"]
    assert found.lost_rate == judged["lost_rate"]
    assert found.torque_dev == pytest.approx(judged["torque_dev_rms"])
    assert costs([policy], scenarios, factory)[0] == [found]
