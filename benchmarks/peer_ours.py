"""Our machine alone, and its drives in blocks: one thread of one process."""

import sys

import numpy as np

from benchmarks.peer_clock import rate, tell
from sensorless.core.api import PLANT_STATE, SIGNAL_N, Array, sim_run
from sensorless.core.machine import plant_run
from sensorless.design.drive import DriveDesign
from sensorless.design.records import plant_record
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import Motor

DRIVES = 256
PERIODS = 100
STEPS = 50_000


def main() -> None:
    """Rates of the machine alone and of the closed loop; with ``drives``, of the latter alone."""
    motor = Motor.load("paper")
    plant, state = plant_record(motor).reshape(1), np.zeros(1, dtype=PLANT_STATE)
    u = np.tile([30.0, 0.0, 0.0], (STEPS, 1))

    def machine() -> int:
        plant_run(plant, state, u)
        return STEPS

    s = Scenarios.nominal(motor, combine(0, np.arange(DRIVES)), 1e5)
    s.omega_0[:] = 350.0 * np.pi / 30.0
    s.omega[:] = s.omega_0[:, None]
    k_s = np.full(DRIVES, 0.5, dtype=np.float32)
    obs = np.zeros((DRIVES, SIGNAL_N), dtype=np.float32)
    rates = {} if "drives" in sys.argv else {"machine alone": rate(machine)}
    for name, twin in {"drive and its sensored twin": True, "drive": False}.items():
        sims = SimFactory(motor, DriveDesign()).build(s, twin=twin)

        def drives(sims: Array = sims) -> int:
            sim_run(sims, PERIODS, k_s, obs)
            return DRIVES * PERIODS

        rates[name] = rate(drives)
        if sims["lost"].any():
            raise RuntimeError("a drive got lost: the figure would be wrong")
    tell(rates, ("numpy",))


if __name__ == "__main__":
    main()
