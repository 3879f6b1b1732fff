"""Random drives of the paper's machine, and their run in the core."""

from typing import Any

import numpy as np

from sensorless.core.api import SIGNAL_N, Array, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.observers.coupled_design import LEAST_FLUX


class Alone(SimFactory):
    """Drives without the twin, which has no say in their angle errors."""

    def build(self, s: Scenarios, **how: Any) -> Array:
        return super().build(s, **{**how, "twin": False})


def drives(n: int = 64) -> Array:
    motor = Motor.load("paper")
    return SimFactory(motor, DriveDesign()).build(
        stress_1_scenarios(motor, np.arange(n, dtype=np.uint64))
    )


def advance(sims: Array, periods: int, threads: int | None, k_s: float = 0.8) -> Array:
    """Run the drives in place."""
    n = len(sims)
    wanted, obs = np.full(n, k_s, np.float32), np.zeros((n, SIGNAL_N), np.float32)
    sim_run(sims, periods, wanted, obs, threads=threads)
    return sims


def flux_model(motor: Motor) -> Floats:
    """``flux_model_t`` of a machine whose iron does not saturate: R_s, L_d, L_q twice, psi_f."""
    least = LEAST_FLUX * motor.psi_f
    values = motor.R_s, motor.L_d, motor.L_q, motor.L_q, motor.psi_f, least**2
    return np.array(values, dtype=np.float32)
