"""Scenarios become machines."""

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import Motor


@pytest.mark.parametrize("name", ["paper", "ipmsm_2200w", "pmsyrm_5600w"])
def test_a_weaker_magnet_has_less_flux(name: str) -> None:
    """Whether the flux map has its magnet as a current or as a flux; saturation takes a part."""
    motor = Motor.load(name)
    s = Scenarios.nominal(motor, np.arange(3, dtype=np.uint64), 1.0)
    s.psi_f = np.array([0.94, 1.0, 1.06])
    psi = SimFactory(motor, DriveDesign()).build(s)["drive"]["y"]["psi_d"]
    assert psi[1] == pytest.approx(motor.psi_f, rel=1e-4)
    assert psi / psi[1] == pytest.approx(s.psi_f, abs=0.015)
