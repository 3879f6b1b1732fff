"""Without torque current, where dead time is the largest voltage, the flux keeps its length."""

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, sim_signals
from sensorless.core.runs import Run
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.machine_family import family
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import MOTORS, Motor
from sensorless.observers.coupled_design import LEFT_IDLE
from sensorless.observers.flux_design import standstill_rate
from sensorless.observers.tracking import voltage_drift

DRIVES = 64


def at_rest(motor: Motor, idle: bool) -> tuple[int, float, float]:
    """Losses in 1.5 s at rest; medians of the largest error [degrees] and the least flux [psi_f].

    The dead time is 1.35 times the file's, sensors are off by up to 0.5 % of rated current.
    """
    s = Scenarios.nominal(motor, np.arange(DRIVES, dtype=np.uint64), 1.5)
    draw = np.random.default_rng(1).uniform
    s.theta_0[:] = draw(-np.pi, np.pi, DRIVES)
    s.offset[:] = 0.005 * motor.i_rated * draw(-1.0, 1.0, (DRIVES, 2))
    s.noise[:] = 0.0015 * motor.i_rated
    s.dead_time *= 1.35
    s.detailed[:] = True
    sims = SimFactory(motor, DriveDesign()).build(s)
    sims["control"]["coupled"]["idle"] *= idle
    sims["go_on"] = True
    obs = np.zeros((DRIVES, SIGNAL_N), np.float32)
    run, led = Run(sims, 10, obs), np.ones(DRIVES, np.float32)
    sim_signals(sims, obs)
    least, most = np.full(DRIVES, np.inf), np.zeros(DRIVES)
    while np.any(sims["k"] < sims["k_end"]):
        run.decide(led)
        x, y = sims["drive"]["x"], sims["drive"]["y"]
        psi = np.hypot(x["coupled"]["psi"]["a"], x["coupled"]["psi"]["b"])
        least = np.minimum(least, psi / motor.psi_f)
        err = np.angle(np.exp(1j * (y["theta_e"] - x["est"]["theta"])))
        most = np.maximum(most, np.degrees(np.abs(err)))
    return int(np.count_nonzero(sims["lost"])), float(np.median(most)), float(np.median(least))


@pytest.mark.parametrize("name", ["brusa_hsm1", "pmsyrm_5600w", "pmsrm_15kw"])
def test_the_flux_keeps_its_length_at_rest(name: str) -> None:
    """Without this correction `brusa_hsm1` has a fifth of its flux left."""
    motor = Motor.load(name)
    lost, error, flux = at_rest(motor, True)
    _, error_without, flux_without = at_rest(motor, False)
    assert lost == 0
    assert flux > 0.5
    assert flux > flux_without + 0.05
    assert error < error_without
    assert (flux_without < 0.3) == (name == "brusa_hsm1")


@pytest.mark.parametrize(
    "motor",
    [*(Motor.load(path.stem) for path in sorted(MOTORS.glob("*.toml"))), *family(1, 16)],
    ids=lambda m: m.name,
)
def test_dead_time_leaves_half_of_the_length(motor: Motor) -> None:
    """All of the file's dead time against the correction at rest."""
    record = control_record(motor, DriveDesign())["coupled"]
    rate = (2.0 * record["gain_0"] + record["idle"]) / motor.T_s
    assert voltage_drift(motor) / rate <= LEFT_IDLE * (1.0 + 1e-6)
    needed = voltage_drift(motor) > LEFT_IDLE * 2.0 * standstill_rate(motor)
    assert (record["idle"] > 0.0) == needed
    assert (record["inv_i_idle"] > 0.0) == needed
