"""The pole where dead time is large beside the magnets: what is left of it looks like an EMF."""

from pathlib import Path

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.rollout import rollout
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

MOTOR = Motor.load(str(Path(__file__).parents[2] / "data" / "traction_150kw.toml"))


def test_an_emf_that_is_not_known_does_not_turn_the_pole() -> None:
    """Of 128 starts 14 took the wrong pole when a peak counted from the sample before it."""
    r = rollout(
        make_policy("eq25", MOTOR), suite("starts", MOTOR, 5, 128), SimFactory(MOTOR, DriveDesign())
    )
    assert (r.lost != 0).sum() <= 2
