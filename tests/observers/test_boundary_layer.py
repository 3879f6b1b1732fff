"""The boundary layer of the coupled observer's correction: as thick as the drifts need it."""

import math
from dataclasses import replace

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.design.records import designed
from sensorless.envs.scenarios.machine_family import member
from sensorless.evaluation.evaluate import evaluate
from sensorless.machine.motor import MOTORS, Motor
from sensorless.observers import coupled_design
from sensorless.observers.coupled_design import LAYER_SPEED, layer
from sensorless.observers.flux_design import standstill_rate
from sensorless.observers.tracking import resistance_drift, voltage_drift
from sensorless.policies.registry import make_policy

QUIET = member(1_000_501, 61)
"""Its dead time takes 0.8 % of the EMF, its resistance 12 %, and little corrects its flux."""


def by_dead_time(motor: Motor) -> float:
    """The layer that an uncompensated dead time asks for alone."""
    return voltage_drift(motor) / (LAYER_SPEED * motor.omega_rated)


@pytest.mark.parametrize("name", sorted(path.stem for path in MOTORS.glob("*.toml")))
def test_shipped_machines_have_dead_time_enough(name: str) -> None:
    motor = Motor.load(name)
    assert layer(motor) == by_dead_time(motor)


def test_the_correction_at_rest_holds_both_drifts() -> None:
    pull = 2.0 * standstill_rate(QUIET) * layer(QUIET)
    assert pull == pytest.approx(voltage_drift(QUIET) + resistance_drift(QUIET))
    assert layer(QUIET) > 1.5 * by_dead_time(QUIET)
    more = replace(QUIET, dead_time=20.0 * QUIET.dead_time)
    assert math.isclose(layer(more), by_dead_time(more))


def unsteady(motor: Motor) -> tuple[int, int]:
    """Drives of 128 ``braking`` that are lost, and that keep lock but not the speed."""
    designed.cache_clear()
    policies = {"eq25": make_policy("eq25", motor)}
    result = evaluate(motor, DriveDesign(), "braking", 31, 128, policies).policies["eq25"]
    return round(128 * result["lost_rate"]), round(128 * result["not_held_rate"])


def test_a_thin_layer_lets_the_flux_follow_its_integration(monkeypatch: pytest.MonkeyPatch) -> None:
    lost, loose = unsteady(QUIET)
    monkeypatch.setattr(coupled_design, "layer", by_dead_time)
    lost_thin, loose_thin = unsteady(QUIET)
    designed.cache_clear()
    assert lost == 0 and loose <= 2
    assert lost_thin >= 5 and loose_thin >= 12
