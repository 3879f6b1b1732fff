"""The same run in the native core: what the page must have, byte for byte."""

import numpy as np

from sensorless.core.api import SIGNAL_N, Array, sim_signals, sim_trace
from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import decide
from sensorless.units import RPM_TO_RAD_S
from web.image import scenario

Move = tuple[int, str, float]
"""Decision, ``speed`` [r/min] or ``load`` [N m], value."""


def final(
    motor: Motor,
    estimator: str,
    word: str,
    levers: dict[str, float],
    moves: list[Move],
    n: int,
    *,
    seek: bool = False,
    seed: int = 0,
) -> Array:
    """Record of ``SIM`` (1,) after n decisions; levers as on the page."""
    share = {key: levers[key] / 100.0 for key in ("resistance", "magnet", "inertia", "link")}
    s = scenario(motor, R_s=share["resistance"], psi_f=share["magnet"], J=share["inertia"])
    s.omega[:, 0], s.tau[:, 0] = RPM_TO_RAD_S * levers["speed"], levers["load"]
    s.u_dc[:, 0] = share["link"]
    s.gain[:, 0], s.offset[:, 0] = levers["gain"] / 100.0, levers["offset"]
    s.seek[:], s.seed[:] = seek, combine(seed, np.arange(1))
    if levers["ramp"]:
        s.omega_rate[:, 0] = levers["ramp"] * RPM_TO_RAD_S
    sim = SimFactory(motor, DriveDesign(estimator=estimator)).build(s)
    sim["k_end"] = np.iinfo(np.int32).max
    policy = make_policy(word, motor)
    obs = np.zeros((1, SIGNAL_N), dtype=np.float32)
    for j in range(n):
        if sim["lost"][0] != 0:
            break
        for at, lever, value in moves:
            if at == j and lever == "speed":
                sim["profile"]["omega_ref"][0, 0] = motor.n_p * (RPM_TO_RAD_S * value)
            elif at == j:
                sim["profile"]["tau"][0, 0] = value
        sim_signals(sim, obs)
        k_s = decide(policy, obs, sim)
        sim_trace(sim, decision_periods(motor), float(k_s[0]))
    return sim
