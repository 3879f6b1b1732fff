"""Field weakening takes voltage, not torque: the speed loop has nothing to take back."""

from pathlib import Path

import numpy as np
import pytest

from sensorless.core.api import Array
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.words import plan_from
from sensorless.evaluation.trace import outcome, trace
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from tests.core.drive.test_control import Call, params, rest, step

FERRITE = str(Path(__file__).parents[2] / "data" / "ferrite_4kw.toml")
"""Three quarters of its torque is the reluctance's, and its rated point needs a weaker field."""


@pytest.mark.parametrize("weakened", [0.0, -2.0, -4.0])
def test_the_torque_current_falls_by_what_reluctance_adds(
    c: Call, motor: Motor, weakened: float
) -> None:
    """psi_f + (L_d - L_q) i_d is torque over torque current, but for 1.5 n_p."""
    p, x = params(motor, mtpa=False, i_q_slew=1e6), rest()
    p["k_p_speed"], p["k_i_speed"], p["k_fw"] = 1e-9, 0.0, 0.0
    x["i_int"], x["i_ref"]["d"], x["i_d_fw"] = 1.0, weakened, weakened
    step(c, motor, p, x, 0j, u_dc=1e5)
    flux = motor.psi_f + float(p["L_d"][0] - p["L_q"][0]) * weakened
    assert float(x["i_ref"]["q"][0]) == pytest.approx(motor.psi_f / flux, rel=1e-6)


def last_swing(motor: Motor, speed: str, load: str, ramp: float) -> Array:
    """Peak to peak of speeds and torques of drive and twin over the last 0.4 s, over rated."""
    plan = plan_from(speed, load, ramp, 2.8, motor, 1)
    run = trace(make_policy("eq25", motor), plan, motor, DriveDesign())
    assert outcome(run) == "kept lock"
    last = run["t"] > 2.4
    scales = (motor.omega_rated / motor.n_p, motor.tau_rated)
    names = ("omega_m", "omega_m_twin", "tau", "tau_twin")
    swing: Array = np.array([np.ptp(run[x][last]) for x in names]) / np.repeat(scales, 2)
    return swing


@pytest.mark.parametrize(
    ("name", "speed", "load", "ramp"),
    [
        (FERRITE, "0:900,0.6:1500", "0:0,1.6:25", 3000.0),
        ("brusa_hsm1", "0:2250,0.4:3750", "0:0,1.2:137", 3750.0),
        ("brusa_hsm1", "0:2880,0.4:4800", "0:0,1.2:116", 4800.0),
    ],
)
def test_a_reluctance_machine_does_not_swing(name: str, speed: str, load: str, ramp: float) -> None:
    """Before, speed swung by up to 12 % of rated, with an encoder too, and torque by 107 %."""
    swing = last_swing(Motor.load(name), speed, load, ramp)
    assert swing[:2].max() < 0.005 and swing[2:].max() < 0.05
