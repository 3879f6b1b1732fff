"""How fast the start sequence follows the EMF: its noise, and what that leaves of a current."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import member
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.rollout import rollout
from sensorless.machine.motor import MOTORS, Motor
from sensorless.observers.injection_signal import sample_error
from sensorless.observers.start_design import (
    EMF_NOISE,
    EMF_PERIODS,
    EMF_TAU,
    FLY_SHARE,
    emf_time,
)
from sensorless.policies.registry import make_policy


def noise(motor: Motor, tau: float) -> float:
    """RMS of the EMF that is followed [V], from white errors of the current samples."""
    error = sample_error(motor) * np.random.default_rng(2).standard_normal(200_000)
    e = motor.L_q * np.diff(error) / motor.T_s
    mean, pole = 0.5 * (e[1:] + e[:-1]), math.exp(-motor.T_s / tau)
    y, out = 0.0, np.empty(len(mean))
    for k, now in enumerate(mean):
        y += (1.0 - pole**2) * (now - y)
        out[k] = y
    return float(np.sqrt(np.mean(out[1000:] ** 2)))


@pytest.mark.parametrize("tau", [8.0, 30.0])
def test_the_noise_of_an_emf_is_the_closed_form(motor: Motor, tau: float) -> None:
    """Not above it; less for few periods, in which the low-pass passes less than 2 T_s / tau."""
    want = math.sqrt(2.0) * motor.L_q * sample_error(motor) / (tau * motor.T_s)
    assert noise(motor, tau * motor.T_s) / want == pytest.approx(1.0, abs=1.3 / tau)


def test_noise_decides_where_periods_are_short_and_sensors_coarse(motor: Motor) -> None:
    fast = replace(motor, T_s=motor.T_s / 20.0)
    coarse = replace(fast, adc_bits=11)
    assert emf_time(motor) == pytest.approx(EMF_PERIODS * motor.T_s)
    assert EMF_PERIODS * fast.T_s <= emf_time(fast) < emf_time(coarse) < EMF_TAU
    fly = FLY_SHARE * motor.omega_rated * motor.psi_f
    assert noise(coarse, emf_time(coarse)) == pytest.approx(EMF_NOISE * fly, rel=0.1)
    assert emf_time(replace(fast, adc_bits=6)) == EMF_TAU


@pytest.mark.parametrize("name", sorted(path.stem for path in MOTORS.glob("*.toml")))
def test_it_is_never_longer_than_catch_allows(name: str) -> None:
    motor = Motor.load(name)
    assert EMF_PERIODS * motor.T_s <= emf_time(motor) <= EMF_TAU


def test_an_emf_that_is_known_soon_does_not_trip_the_drive() -> None:
    """Of these 96 starts 14 tripped when the EMF was followed in 1.25 ms."""
    motor = member(1000555, 48)
    r = rollout(
        make_policy("eq25", motor), suite("starts", motor, 5, 96), SimFactory(motor, DriveDesign())
    )
    assert (r.lost != 0).sum() <= 8
