"""Crossing the band: hard switch against blend, and Eq. 25 on the hand-over suite."""

from typing import Any

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.rollout import rollout
from sensorless.evaluation.steady import steady
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy


@pytest.mark.parametrize(
    ("k_s", "shares"), [(1.0, (0.0, 0.05, 0.1, 0.2)), (0.0, (0.2, 0.3, 0.6, 1.0))]
)
def test_each_estimator_holds_its_range(
    motor: Motor, k_s: float, shares: tuple[float, ...]
) -> None:
    """Rated torque both ways: injection from standstill to 20 % speed, the observer from there."""
    speed, torque = np.meshgrid(shares, [-1.0, 1.0])
    rpm, tau = motor.n_rated_rpm * speed.ravel(), motor.tau_rated * torque.ravel()
    run = steady(motor, DriveDesign(estimator="smo"), rpm, tau, k_s, settle=2.0)
    assert run.held.all()


@pytest.mark.parametrize(
    "sensors", ["exact sensors", "12 bits and dead time", "real sensors, mean run"]
)
def test_blend_takes_the_step_out_of_the_torque(data: dict[str, Any], sensors: str) -> None:
    """Published estimators at 4 N m: peak to peak less by 40 % up and by 80 % down.

    With the noise of real sensors that is so for the mean of many runs; a single one is noise.
    """
    rows = data["cases"]["switching"]["rows"]
    up, down = (rows[f"{sensors}: blend less by, {way}"]["published"] for way in ("up", "down"))
    assert isinstance(up, float) and up > 40.0
    assert isinstance(down, float) and down > 80.0


@pytest.mark.parametrize("seed", [1, 2])
def test_eq25_survives_the_hand_over_suite(motor: Motor, seed: int) -> None:
    """Corrected estimators, nominal parameters, all 52 kinds of crossing."""
    run = rollout(
        make_policy("eq25", motor),
        suite("handoff", motor, seed, 52),
        SimFactory(motor, DriveDesign(estimator="smo")),
    )
    assert np.flatnonzero(run.lost).tolist() == []
