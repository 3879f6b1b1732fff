"""The shipped drive on a plant of other code, beside the simulator, which should not flatter.

    python -m tests.independent.run --suite stress-1 --seed 90211 --size 100

Eq. 25 on the default drive of ``paper``: ``drive_step`` with samples of ``plant.py``, noise of
its own and the profiles of the suite, and the same scenarios on ``carrier=true``. Prints losses,
mean RMS and largest angle error, and torque deviation from the simulator's sensored twin.
"""

import argparse
from dataclasses import dataclass

import numpy as np

from sensorless.core.api import Array, lib, pointer, struct_dtype
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import LOST_ANGLE_DEG, LOST_TIME, Scenarios, SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.evaluation.trace import Trace, trace
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from tests.independent.plant import PHASES, Plant

DECISION = 5
"""Periods between two weights, 1 ms."""


@dataclass(frozen=True)
class Outcome:
    """Angle errors [rad] and torques [N m], (periods, n), here and in the simulator."""

    err: Floats
    tau: Floats
    err_sim: Floats
    tau_sim: Floats
    tau_twin: Floats


def _columns(traces: list[Trace], name: str) -> Floats:
    return np.stack([np.asarray(t[name], dtype=np.float64) for t in traces], axis=1)


def run(motor: Motor, scenarios: Scenarios, steps: int = 20) -> Outcome:
    """Run scenarios of one length under Eq. 25 on both, ``steps`` a period on the plant here."""
    design, policy = DriveDesign(carrier=True), make_policy("eq25", motor)
    n = len(scenarios)
    traces = [trace(policy, scenarios[j : j + 1], motor, design, go_on=True) for j in range(n)]
    sims = SimFactory(motor, design).build(scenarios)
    y, sensor = sims["drive"]["y"], sims["sensor"]
    theta = np.array(y["theta_e"], dtype=np.float64)
    psi = (y["psi_d"] + 1j * y["psi_q"]) * np.exp(1j * theta)
    flux_map = sims["plant"]["map"].copy()
    plant = Plant(motor, scenarios, flux_map, psi, theta, np.array(y["omega_m"], dtype=np.float64))
    x, control = sims["drive"]["x"].copy(), sims["control"].copy()
    inputs = np.zeros(n, dtype=struct_dtype("drive_in_t"))
    kinds = ("drive_params_t[]", "drive_state_t[]", "drive_in_t[]")
    params, states, ins = (
        pointer(a, kind) for a, kind in zip((control, x, inputs), kinds, strict=True)
    )
    given = {k: _columns(traces, k) for k in ("omega_m_ref", "tau_load", "u_dc")}
    random, waiting = np.random.default_rng(1), np.zeros(n, dtype=np.complex128)
    err, tau = np.zeros((2, *given["u_dc"].shape))
    for k in range(len(err)):
        i = plant.current(plant.psi, plant.theta)
        inputs["i_a"] = _sample(sensor, i.real, "a", random)
        inputs["i_b"] = _sample(sensor, (i * PHASES[1].conj()).real, "b", random)
        inputs["u_dc"], inputs["omega_ref"] = given["u_dc"][k], given["omega_m_ref"][k] * motor.n_p
        if k % DECISION == 0:
            speed = np.abs(x["signal"]["omega"]) / motor.omega_rated
            inputs["k_s_ref"] = np.clip((4.0 / 15.0 - speed) * 15.0, 0.0, 1.0)
        tau[k] = plant.torque()
        u = [lib.drive_step(params + j, states + j, ins + j) for j in range(n)]
        err[k] = np.angle(np.exp(1j * (plant.theta - x["est"]["theta"])))
        plant.advance(waiting, given["u_dc"][k], given["tau_load"][k], steps)
        waiting = np.array([v.a + 1j * v.b for v in u])
    return Outcome(err, tau, *(_columns(traces, c) for c in ("theta_e_err", "tau", "tau_twin")))


def _sample(sensor: Array, i: Floats, channel: str, random: np.random.Generator) -> Floats:
    noise = sensor["noise_rms"] * random.standard_normal(len(i))
    read = sensor[f"gain_{channel}"] * i + sensor[f"offset_{channel}"] + noise
    steps = np.round(read / sensor["lsb"]) * sensor["lsb"]
    return np.asarray(np.clip(steps, -sensor["range"], sensor["range"]))


def rms(x: Floats) -> Floats:
    """Root of the mean square over the periods, (n,)."""
    return np.asarray(np.sqrt(np.mean(x**2, axis=0)))


def lost(err: Floats, T_s: float) -> Array:
    """Whether the angle was off for too long, (n,)."""
    beyond, most = np.zeros(err.shape[1]), np.zeros(err.shape[1])
    for row in np.abs(np.rad2deg(err)) > LOST_ANGLE_DEG:
        beyond = (beyond + 1.0) * row
        most = np.maximum(most, beyond)
    return np.asarray(most * T_s > LOST_TIME)


def main() -> None:
    """Run a suite and print both."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--suite", default="stress-1")
    parser.add_argument("--seed", type=int, default=90211)
    parser.add_argument("--size", type=int, default=100)
    options = parser.parse_args()
    motor = Motor.load("paper")
    scenarios = SuiteRows(options.suite, motor, options.seed, options.size).draw()
    scenarios.duration[:] = scenarios.duration.min()
    o = run(motor, scenarios)
    for name, err, tau in (("here", o.err, o.tau), ("simulator", o.err_sim, o.tau_sim)):
        gone, degrees = lost(err, motor.T_s), np.rad2deg(err)
        deviation = 100.0 * rms(tau - o.tau_twin)[~gone] / motor.tau_rated
        print(
            f"{name:10}{gone.sum():3} lost  angle {rms(degrees)[~gone].mean():.2f}, largest "
            f"{np.abs(degrees[:, ~gone]).max():.1f} deg  deviation {deviation.mean():.2f} %"
        )


if __name__ == "__main__":
    main()
