"""gym-electric-motor's PMSM: machine, averaged converter and constant speed; no controller."""

import warnings

import numpy as np

from benchmarks.peer_clock import rate, tell
from benchmarks.words import parser

STEPS = 100


def main() -> None:
    """Steps of 200 us of the environment, and of its simulated system alone, with two solvers."""
    parser(__doc__).parse_args()
    import gym_electric_motor as gem
    from gym_electric_motor import physical_systems

    warnings.simplefilter("ignore")
    action, rates = np.array([0.1, 0.0, -0.1]), {}
    for name, solver in {
        "euler": physical_systems.EulerSolver,
        "scipy": physical_systems.ScipyOdeSolver,
    }.items():
        env = gem.make("Cont-CC-PMSM-v0", ode_solver=solver(), constraints=(), tau=2e-4).unwrapped
        env.reset()

        def environment(env: gem.ElectricMotorEnvironment = env) -> int:
            for _ in range(STEPS):
                env.step(action)
            return STEPS

        def system(plant: gem.PhysicalSystem = env.physical_system) -> int:
            for _ in range(STEPS):
                plant.simulate(action)
            return STEPS

        rates[f"environment, {name}"] = rate(environment)
        env.physical_system.reset()
        rates[f"system alone, {name}"] = rate(system)
    tell(rates, ("gym_electric_motor", "numpy", "scipy", "gymnasium"))


if __name__ == "__main__":
    main()
