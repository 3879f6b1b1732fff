"""A generator with little voltage and a hot winding: what the coupled observer corrects there."""

import numpy as np
import pytest

from sensorless.core.api import TRACE_NAMES, sim_trace
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.machine_family import family
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import MOTORS, Motor
from sensorless.observers.coupled_design import BRAKED, DAMPING, damping


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("resistance", "most"), [(1.0, 10.0), (1.3, 15.0), (1.5, 20.0)])
def test_a_hot_winding_does_not_slip(way: float, resistance: float, most: float) -> None:
    """Slowed down to 0.24 of rated speed, without injection, by a load that drives the shaft.

    The EMF drives the current through the resistance, next to no voltage is left. With 1.5 times
    the file's resistance and all of the flux correction there is no angle at rest: the estimate
    slips by whole turns.
    """
    motor = Motor.load("formula_wheel")
    rated = way * motor.omega_m_rated
    s = Scenarios.nominal(motor, np.array([1], dtype=np.uint64), 1.0)
    s.omega_0[:], s.omega[:], s.omega_rate[:] = 0.6 * rated, 0.24 * rated, 2.0 * abs(rated)
    s.t[:, 1], s.tau[:, 1:] = 0.02, -way * 0.9 * motor.tau_rated
    s.tau_rate[:] = motor.tau_rated / 0.05
    s.R_s[:] = resistance
    sim = SimFactory(motor, DriveDesign()).build(s)
    trace = sim_trace(sim, int(sim["k_end"][0]), 0.0)
    column = {name: trace[:, j] for j, name in enumerate(TRACE_NAMES)}
    assert np.degrees(np.abs(column["theta_e_err"])).max() < most
    assert np.all(column["k_s"][len(trace) // 4 :] == 0.0)


@pytest.mark.parametrize(
    "motor",
    [*(Motor.load(path.stem) for path in sorted(MOTORS.glob("*.toml"))), *family(1, 16)],
    ids=lambda m: m.name,
)
def test_braking_counts_where_the_resistance_bounds_the_damping(motor: Motor) -> None:
    """The rate that leans the angle by ``BRAKED``, if all of the resistance were wrong."""
    record = control_record(motor, DriveDesign())["coupled"]
    if damping(motor) == DAMPING[1]:
        assert record["brake"] == 0.0
        return
    omega, i, psi = 0.3 * motor.omega_rated, motor.i_rated, motor.psi_f
    rate = omega**2 * psi / (float(record["brake"]) * i * motor.T_s)  # share 1 up to this [1/s]
    assert 2.0 * rate * motor.R_s * i / (psi * omega**2) == pytest.approx(BRAKED)
