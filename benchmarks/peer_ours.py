"""Our machine alone, and its drives in blocks: one thread of one process."""

import numpy as np

from benchmarks.peer_clock import rate, tell
from benchmarks.words import parser
from sensorless.core.api import PLANT_STATE, SIGNAL_N, Array, sim_run
from sensorless.core.machine import plant_run
from sensorless.design.drive import DriveDesign
from sensorless.design.records import plant_record
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import Motor
from sensorless.units import rad_per_s

DRIVES = 256
PERIODS = 100
STEPS = 50_000


def main() -> None:
    """Rates of the machine alone and of the closed loop; with ``drives``, of the latter alone."""
    words = parser(__doc__)
    words.add_argument("what", nargs="?", choices=["drives"], help="only the drives")
    machine_too = words.parse_args().what is None
    motor = Motor.load("paper")
    plant, state = plant_record(motor).reshape(1), np.zeros(1, dtype=PLANT_STATE)
    u = np.tile([30.0, 0.0, 0.0], (STEPS, 1))

    def machine() -> int:
        plant_run(plant, state, u)
        return STEPS

    s = Scenarios.nominal(motor, combine(0, np.arange(DRIVES)), 1e5)
    s.omega_0[:] = rad_per_s(350.0)
    s.omega[:] = s.omega_0[:, None]
    k_s = np.full(DRIVES, 0.5, dtype=np.float32)
    obs = np.zeros((DRIVES, SIGNAL_N), dtype=np.float32)
    rates = {"machine alone": rate(machine)} if machine_too else {}
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
