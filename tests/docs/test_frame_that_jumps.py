"""Figures of docs/theory-injection.md, "A frame that jumps": the loop without the cure."""

import math
from pathlib import Path

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.magnetics import cross_angle, mtpa
from sensorless.machine.motor import MOTORS, Motor
from sensorless.machine.saliency import principal

PAGE = (Path(__file__).parents[2] / "docs" / "theory-injection.md").read_text(encoding="utf-8")


def growth(gamma: float) -> float:
    """Factor of four periods of the recursion phi' = phi + K e', K I / (4 X) = gamma."""
    turn = np.eye(3)
    for sign in (1.0, -1.0, 1.0, -1.0):
        g = sign * gamma
        turn = np.array([[1.0 - g, 2.0 * g, -g], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]) @ turn
    return float(np.abs(np.linalg.eigvals(turn)).max())


def test_it_grows_beyond_one_over_root_two() -> None:
    most = 1.0 / math.sqrt(2.0)
    assert growth(0.999 * most) == pytest.approx(1.0)
    assert 1.001 < growth(1.01 * most) < growth(1.1 * most)


def gamma(motor: Motor) -> float:
    """The largest up to ``i_max``, along the axes on which injection locks."""
    coupled = control_record(motor, DriveDesign())["coupled"]
    i = mtpa(motor)
    cross = cross_angle(motor, i)
    along = np.abs(i[:, 0] * np.cos(cross) - i[:, 1] * np.sin(cross))
    answer = 0.5 * motor.T_s * motor.u_inj / principal(motor, i)[:, 0]
    gain = float(coupled["k_h"]) * float(coupled["inv_slope"])
    return float(np.max(0.25 * gain * along / answer))


def test_gamma_of_the_machines() -> None:
    found = {path.stem: gamma(Motor.load(path.stem)) for path in MOTORS.glob("*.toml")}
    told = (f"{found.pop('brusa_hsm1'):.1f}", f"{min(found.values()):.1f}")
    assert f"γ is {told[1]} to {max(found.values()):.2f} on six of those that ship" in PAGE
    assert f"but {told[0]} on `brusa_hsm1`" in PAGE
