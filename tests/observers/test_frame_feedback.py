"""Injection in a frame that its own corrections turn: where it swings, computed and on drives."""

from dataclasses import replace

import numpy as np
import pytest

from sensorless.core.api import TRACE_NAMES, sim_trace
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import MOTORS, Motor
from sensorless.observers.frame_feedback import MOST, frame_feedback
from sensorless.suitability.examine import examine

BRUSA, DESIGN = Motor.load("brusa_hsm1"), DriveDesign()


def growth(gamma: float) -> float:
    """Factor of four periods of the recursion phi' = phi + K e, K I / (4 i_h) = gamma."""
    turn = np.eye(3)
    for sign in (1.0, -1.0, 1.0, -1.0):
        g = sign * gamma
        turn = np.array([[1.0 - g, 2.0 * g, -g], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]) @ turn
    return float(np.abs(np.linalg.eigvals(turn)).max())


def test_it_grows_beyond_one_over_root_two() -> None:
    assert growth(0.999 * MOST) == pytest.approx(1.0)
    assert 1.001 < growth(1.01 * MOST) < growth(1.1 * MOST)


def swing(load: float, design: DriveDesign = DESIGN) -> float:
    """Share of the angle error's power at a quarter of the PWM frequency, at rest under a load."""
    s = Scenarios.nominal(BRUSA, np.array([1], dtype=np.uint64), 0.6)
    s.tau[:], s.noise[:] = load * BRUSA.tau_rated, 0.0
    sim = SimFactory(BRUSA, design).build(s)
    rows = sim_trace(sim, round(0.5 / BRUSA.T_s), 1.0)[-400:]
    x = rows[:, TRACE_NAMES.index("theta_e_err")]
    spectrum = np.abs(np.fft.rfft(x - x.mean()))
    return float(spectrum[100] ** 2 / np.sum(spectrum**2))


def test_the_machine_that_swings_is_told() -> None:
    found = {path.stem: frame_feedback(Motor.load(path.stem)) for path in MOTORS.glob("*.toml")}
    assert found.pop("brusa_hsm1") == pytest.approx(1.145, abs=1e-3)
    assert max(found.values()) == pytest.approx(0.39, abs=1e-3), "docs/bring-a-motor.md has both"
    for motor, told in ((BRUSA, True), (replace(BRUSA, u_inj=3.0 * BRUSA.u_inj), False)):
        said = [f for f in examine(motor, 15.0).findings if "quarter of the PWM" in f.text]
        assert bool(said) == told and all(f.weight == "note" for f in said)


def test_a_drive_swings_from_the_load_on_that_gamma_says() -> None:
    assert swing(1.2) > 0.5 > 0.1 > swing(0.2)
    assert swing(1.2, DriveDesign(coupled_injection_hz=20.0)) < 0.1, "what the note advises"
