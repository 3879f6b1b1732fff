"""Where drives are and what they do there."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.core.api import SIM
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.evaluation.metrics.catalogue import angle_err_rms_deg, torque_dev_rms
from sensorless.evaluation.metrics.place import (
    QUADRANTS,
    SPEED_EDGES,
    by_place,
    quadrant,
    speed_bin,
)
from sensorless.evaluation.metrics.ripple import torque_ripple_rms
from sensorless.evaluation.rollout import CAUSES, Rollout, rollout
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

MOTOR = Motor.load("paper")
RATED = MOTOR.omega_m_rated
FACTORY = SimFactory(MOTOR, DriveDesign(estimator="smo", L_q_motoring=0.7))


def told(speed: list[float], torque: list[float], live: int, **fields: float) -> Rollout:
    """One drive whose twin has these speeds and torques, over rated, in decisions of 5 periods."""
    sums = np.zeros((len(speed), 1), dtype=SIM["sums"])
    for name, x in {"omega_m_twin": RATED * np.array(speed), **fields}.items():
        sums[name][:, 0] = 5.0 * np.asarray(x)
    sums["tau_twin"][:, 0] = 5.0 * MOTOR.tau_rated * np.array(torque)
    sums["n"] = 5.0
    sums[live:] = np.zeros((), dtype=SIM["sums"])
    scenario = Scenarios.nominal(MOTOR, np.ones(1, dtype=np.uint64), 1.0)
    lost = np.array([int(live < len(speed))], dtype=np.int32)
    return Rollout(MOTOR, scenario, sums, lost, np.array([5 * live]))


def test_quadrants_and_bins_by_hand() -> None:
    speed = [0.31, 0.31, -0.31, -0.31, 0.009, 0.31, 0.07, -1.3, 0.011, 0.31]
    torque = [0.5, -0.5, -0.5, 0.5, 1.0, 0.019, 0.5, 0.5, 0.5, 0.021]
    r = told(speed, torque, 10)
    assert [QUADRANTS[i] for i in quadrant(r)[:, 0]] == [
        "forward motoring",
        "forward regenerating",
        "reverse motoring",
        "reverse regenerating",
        "standstill",
        "no load",
        "forward motoring",
        "reverse regenerating",
        "forward motoring",
        "forward motoring",
    ]
    bins = [SPEED_EDGES[i] for i in speed_bin(r)[:, 0]]
    assert bins == [0.3, 0.3, 0.3, 0.3, 0, 0.3, 0.05, 1.0, 0, 0.3]


def test_a_lost_drive_was_lost_where_it_lived_last() -> None:
    r = told([0.3, 0.3, -0.3, 0.7], [0.5, -0.5, -0.5, 0.5], 2, err_sq=4.0, dev_sq=9.0)
    places = by_place(r)["quadrant"][0]
    assert places["periods"].tolist() == [5, 5, 0, 0, 0, 0]
    assert places["lost"].tolist() == [False, True, False, False, False, False]
    assert places["err_sq"].tolist() == [20.0, 20.0, 0, 0, 0, 0]
    assert places["dev_sq"][1] == pytest.approx(45.0 / MOTOR.tau_rated**2)


def test_what_is_not_feasible_was_lost_nowhere() -> None:
    r = told([0.3, 0.3], [0.5, 0.5], 1)
    lost = np.array([CAUSES["angle"] | CAUSES["twin"]], dtype=np.int32)
    assert not any(x["lost"].any() for x in by_place(replace(r, lost=lost)).values())
    assert any(x["lost"].any() for x in by_place(r).values())


def test_a_drive_that_never_lived_was_nowhere() -> None:
    places = by_place(told([0.3], [0.5], 0))
    assert not any(x["lost"].any() or x["periods"].any() for x in places.values())


@pytest.fixture(scope="module")
def stressed() -> Rollout:
    return rollout(
        make_policy("smo", MOTOR),  # without injection: loses those at rest
        stress_1_scenarios(MOTOR, np.arange(24, dtype=np.uint64)),
        FACTORY,
    )


@pytest.mark.parametrize("kind", ["quadrant", "speed"])
def test_places_add_up_to_the_whole_life(stressed: Rollout, kind: str) -> None:
    places = by_place(stressed)[kind]
    count = places["periods"].sum(axis=1)
    np.testing.assert_array_equal(count, stressed.periods)
    for name, metric, factor in (
        ("err_sq", angle_err_rms_deg, np.rad2deg(1.0)),
        ("dev_sq", torque_dev_rms, 1.0),
        ("ripple_sq", torque_ripple_rms, 1.0),
    ):
        rms = factor * np.sqrt(places[name].sum(axis=1) / count)
        np.testing.assert_allclose(rms, metric(stressed), rtol=1e-6)
    assert (stressed.lost != 0).any()
    np.testing.assert_array_equal(places["lost"].sum(axis=1), stressed.lost != 0)


@pytest.mark.parametrize(("way", "load"), [(1, 1), (1, -1), (-1, -1), (-1, 1)])
def test_a_steady_drive_is_in_its_quadrant(way: int, load: int) -> None:
    s = Scenarios.nominal(MOTOR, np.arange(1, dtype=np.uint64), 0.6)
    s.omega_0[:], s.omega[:] = way * 0.4 * RATED, way * 0.4 * RATED
    s.tau[:] = load * 0.5 * MOTOR.tau_rated
    s.tau_rate[:] = MOTOR.tau_rated / 0.05
    r = rollout(make_policy("eq25", MOTOR), s, FACTORY)
    name = ("forward" if way > 0 else "reverse") + (" motoring" if way == load else " regenerating")
    assert QUADRANTS[quadrant(r)[-1, 0]] == name
    assert by_place(r)["quadrant"][0]["periods"][QUADRANTS.index(name)] > 2000
