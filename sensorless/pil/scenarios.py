"""Scenarios for the processor in the loop: what a drive meets, and one case that it loses."""

import dataclasses

import numpy as np

from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.suites import suite
from sensorless.machine.motor import Motor
from sensorless.observers.start_design import knows_poles

PLANS: dict[str, tuple[tuple[float, float, float], ...]] = {
    "start from standstill": ((0.0, 0.0, 0.0), (0.05, 0.5, 0.0)),
    "hand-over both ways": ((0.0, 0.1, 0.0), (0.2, 0.4, 0.2), (1.0, 0.1, 0.2), (1.6, 0.4, 0.4)),
    "load steps": ((0.0, 0.25, 0.0), (0.5, 0.25, 0.6), (1.0, 0.25, -0.4), (1.5, 0.25, 0.3)),
    "reversal": ((0.0, 0.35, 0.1), (0.6, -0.35, 0.1), (1.5, 0.0, 0.0)),
    "rated speed": ((0.0, 1.0, 0.0), (1.2, 1.0, 0.5)),
    "unknown angle": ((0.0, 0.0, 0.3), (0.1, 0.5, 0.3)),
    "spinning shaft": ((0.0, -0.6, 0.0), (0.3, 0.3, 0.0)),
    "broken sensor": ((0.0, 0.3, 0.0), (0.6, 0.3, 0.5)),
}
"""Start [s], speed target [rated], load [rated]. Two drives find their rotor first; the last one
has a broken current sensor."""

BROKEN = 1.5
"""Offset of the broken sensor [rated current]."""

RATE = 1.0
"""Slope of the speed reference [rated/s]."""
DURATION = 2.0


def pil_scenarios(motor: Motor, seed: int, size: int) -> tuple[tuple[str, ...], Scenarios]:
    """Names and scenarios: the planned ones, filled up to ``size`` with random ones.

    The controller's numbers are always those of the export, so scenarios differ in the machine, its
    load and its sensors only.
    """
    planned = Scenarios.nominal(
        motor, np.arange(len(PLANS), dtype=np.uint64) + np.uint64(seed), DURATION
    )
    rated = motor.omega_m_rated
    for j, plan in enumerate(PLANS.values()):
        for i, (t, omega, tau) in enumerate(plan):
            planned.t[j, i] = t
            planned.omega[j, i:], planned.tau[j, i:] = omega * rated, tau * motor.tau_rated
    planned.omega_rate[:] = RATE * rated
    resting, spinning = (list(PLANS).index(name) for name in ("unknown angle", "spinning shaft"))
    planned.seek[[resting, spinning]] = knows_poles(motor)
    planned.theta_err_0[resting] = 2.5 * knows_poles(motor)  # else nothing finds the pole at rest
    planned.omega_0[spinning] = PLANS["spinning shaft"][0][1] * rated
    planned.offset[-1, 0] = BROKEN * motor.i_rated
    random = suite("stress-1", motor, seed, size - len(PLANS))
    random.L_q_hat[:] = random.cross_hat[:] = 1.0
    names = (*PLANS, *(f"stress-1:{seed}:{j}" for j in range(len(random))))
    return names, join(planned, random)


def join(*parts: Scenarios) -> Scenarios:
    """Join the rows of several batches."""
    fields = [f.name for f in dataclasses.fields(Scenarios)]
    return Scenarios(**{f: np.concatenate([getattr(p, f) for p in parts]) for f in fields})
