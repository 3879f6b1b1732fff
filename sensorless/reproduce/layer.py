"""Eq. 24 of the source paper: how much of the time the sigmoid is a straight line."""

import numpy as np

from sensorless.core.api import SIGNAL_N, sim_run, sim_signals
from sensorless.core.runs import running
from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.observers.smo_design import deadbeat_gain
from sensorless.policies.registry import make_policy
from sensorless.policy import decide
from sensorless.reproduce.case import CORRECTED, PUBLISHED, Case, row_of

SEED, SIZE = 11, 64
STRAIGHT = 0.39946
"""Largest x with tanh(x) >= 0.95 x."""


def arguments(motor: Motor, design: DriveDesign) -> Floats:
    """|a x / 2| of the sigmoid at every decision of every drive that runs, larger of both axes.

    Drives of ``stress-1`` under Eq. 25; a decision is 1 ms.
    """
    policy = make_policy("eq25", motor)
    scenarios = suite("stress-1", motor, SEED, SIZE)
    sims = SimFactory(motor, design).build(scenarios, settings=policy.settings, twin=False)
    obs = np.zeros((len(sims), SIGNAL_N), dtype=np.float32)
    sim_signals(sims, obs)
    policy.reset(len(sims))
    found = []
    while (live := running(sims)).any():
        k_s = decide(policy, obs.copy(), sims)
        sim_run(sims, decision_periods(motor), k_s, obs)
        z = sims["drive"]["x"]["smo"]["z"][live]
        share = np.maximum(np.abs(z["a"]), np.abs(z["b"])) / sims["control"]["smo"]["k"][live]
        found.append(np.arctanh(np.minimum(share, 0.999).astype(np.float64)))
    return np.concatenate(found)


def boundary_layer(motor: Motor) -> Case:
    """Set how far the observers leave the straight part of their sigmoid side by side."""
    designs = (PUBLISHED, CORRECTED)
    found = [arguments(motor, d) for d in designs]
    width = [
        d.smo_k * motor.omega_rated * motor.psi_f / (d.smo_gain * deadbeat_gain(motor))
        for d in designs
    ]
    return Case(
        "layer",
        "Eq. 24: the sigmoid, a boundary layer that the observer does not leave",
        f"suite stress-1, seed {SEED}, {SIZE} scenarios, Eq. 25, read every millisecond until the "
        "end or lost lock; x = current error of the model, the larger of both axes",
        (
            row_of("half width of the layer, 2/a", "A", "–", width),
            row_of("median of |a x/2|", "1", "–", [float(np.median(x)) for x in found], 3),
            row_of("inside the layer, |a x/2| < 1", "%", "–", [within(x, 1.0) for x in found], 3),
            row_of(
                "tanh within 5 % of a straight line",
                "%",
                "–",
                [within(x, STRAIGHT) for x in found],
                3,
            ),
        ),
        "g = k a/2 is at most about L_d/T_s and the bound k exceeds the EMF, so the layer is wider "
        "than the current error gets, but for drives that are about to lose lock. Inside, z = g x: "
        "the observer is linear, of gain g, and does not slide. With `smo_switching=sign` and "
        "`super_twisting` it does.",
    )


def within(x: Floats, most: float) -> float:
    """Share of the values up to ``most`` [%]."""
    return 100.0 * float(np.mean(x < most))
