"""Speed of the compiled core: PWM periods per second.

A PWM period is one control step and one plant step of one drive. A scenario with its sensored twin
is two drives in lock-step; ``pwm`` counts both, ``scenario`` counts the drive under test alone. All
variants simulate every effect: saturation, dead time, DC-link limit, sampling noise, offset, gain
and resolution, one period of delay.
"""

from typing import Any

import numpy as np

from benchmarks.timing import Run, best_rates
from sensorless.core.api import SIGNAL_N, lib, sim_run
from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import Motor
from sensorless.units import rad_per_s

DECISION = decision_periods(Motor.load("paper"))
"""Periods of a decision."""

LONG = 250
"""Periods of a long call: going into a block and back no longer counts."""

SMALLEST = 20_000
"""Periods between two looks at the clock, about."""

SIMD = {lib.SIMD_NONE: "none", lib.SIMD_AVX2: "AVX2", lib.SIMD_AVX512: "AVX-512"}
"""Names of the sets of vector instructions."""


def core_loop(
    n: int, *, twin: bool, periods: int, simd: int, threads: int = 1, estimator: str = "smo"
) -> Run:
    """n drives at 350 r/min between both observers, ``periods`` a call; counts their periods."""
    motor = Motor.load("paper")
    s = Scenarios.nominal(motor, combine(0, np.arange(n)), 1e5)
    s.omega_0[:] = rad_per_s(350.0)
    s.omega[:] = s.omega_0[:, None]
    sims = SimFactory(motor, DriveDesign(estimator=estimator)).build(s, twin=twin)
    k_s = np.full(n, 0.5, dtype=np.float32)
    obs = np.zeros((n, SIGNAL_N), dtype=np.float32)
    calls = max(1, SMALLEST // (n * periods))

    def run() -> int:
        for _ in range(calls):
            sim_run(sims, periods, k_s, obs, simd=simd, threads=threads)
        if sims["lost"].any():
            raise RuntimeError("a drive got lost: the figure would be wrong")
        return calls * n * periods

    return run


def measure(seconds: float) -> dict[str, Any]:
    """Periods per second of every variant, and ratios."""
    none, best = lib.SIMD_NONE, lib.sim_simd()
    runs = {
        "scalar": core_loop(64, twin=True, periods=LONG, simd=none),
        "scalar_decision": core_loop(64, twin=True, periods=DECISION, simd=none),
        "scalar_alone": core_loop(64, twin=False, periods=LONG, simd=none),
        "batched": core_loop(64, twin=True, periods=LONG, simd=best),
        "batched_decision": core_loop(64, twin=True, periods=DECISION, simd=best),
        "batched_alone": core_loop(64, twin=False, periods=LONG, simd=best),
        "batched_avx2": core_loop(64, twin=True, periods=LONG, simd=lib.SIMD_AVX2),
        "flux_scalar": core_loop(64, twin=True, periods=LONG, simd=none, estimator="flux"),
        "flux_batched": core_loop(64, twin=True, periods=LONG, simd=best, estimator="flux"),
        "one_thread": core_loop(512, twin=True, periods=LONG, simd=best),
        "two_threads": core_loop(512, twin=True, periods=LONG, simd=best, threads=2),
    }
    scenario = best_rates(runs, seconds)
    pwm = {name: rate if "alone" in name else 2.0 * rate for name, rate in scenario.items()}
    return {
        "simd": SIMD[best],
        "scenario_periods_per_s": scenario,
        "pwm_periods_per_s": pwm,
        "ratios": {
            "batched_over_scalar": pwm["batched"] / pwm["scalar"],
            "batched_over_scalar_decision": pwm["batched_decision"] / pwm["scalar_decision"],
            "batched_over_scalar_alone": pwm["batched_alone"] / pwm["scalar_alone"],
            "batched_avx2_over_scalar": pwm["batched_avx2"] / pwm["scalar"],
            "flux_batched_over_scalar": pwm["flux_batched"] / pwm["flux_scalar"],
            "two_threads_over_one": pwm["two_threads"] / pwm["one_thread"],
        },
    }
