"""Random machines: repeatable, in their ranges, consistent, and fit to be driven."""

import math

import numpy as np
import pytest

from sensorless.design.control import operating_line
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import (
    LEAST_TORQUE,
    MOST_MACHINES,
    MOST_TORQUE,
    PERIODS,
    RANGES,
    family,
    family_digest,
    member,
)
from sensorless.envs.scenarios.suites import suite
from sensorless.errors import UserError
from sensorless.evaluation.rollout import rollout
from sensorless.machine.magnetics import flux, inverse_inductance, torque
from sensorless.machine.motor import MOTORS, Motor
from sensorless.policies.registry import make_policy
from tests.helpers.drives import Alone

FIRST = range(16)


@pytest.fixture(scope="module")
def machines() -> tuple[Motor, ...]:
    """The family that is drawn for a training with 24 machines."""
    return family(1, 24)


def test_a_machine_follows_from_seed_and_index_alone(machines: tuple[Motor, ...]) -> None:
    two = tuple(member.__wrapped__(1, i) for i in (3, 1))  # drawn anew
    assert two == (machines[3], machines[1]) and family(1, 5) == machines[:5]
    assert len({motor.digest for motor in (*machines, *family(2, 4))}) == 28
    assert family_digest(two) == family_digest(machines[3:0:-2]) != family_digest(machines[:2])


@pytest.mark.parametrize(("seed", "n"), [(-1, 4), (2**63, 4), (1, 0), (1, MOST_MACHINES + 1)])
def test_out_of_range(seed: int, n: int) -> None:
    with pytest.raises(UserError, match=r"seed|machines"):
        family(seed, n)


@pytest.mark.parametrize("index", FIRST)
def test_numbers_are_in_their_ranges_and_belong_together(
    index: int, machines: tuple[Motor, ...]
) -> None:
    motor = machines[index]
    base = motor.u_dc / math.sqrt(3.0) / motor.omega_rated
    speed = motor.omega_m_rated
    found = {
        "n_p": motor.n_p,
        "emf": motor.psi_f / base,
        "x_d": motor.L_d * motor.i_rated / base,
        "saliency": motor.L_q / motor.L_d,
        "r": motor.R_s * motor.i_rated / (base * motor.omega_rated),
        "start_time": motor.J * speed / motor.tau_rated,
        "friction": motor.B * speed / motor.tau_rated,
        "i_max": motor.i_max / motor.i_rated,
        **{name: getattr(motor, name) for name in ("n_rated_rpm", "u_dc", "i_rated", "T_s")},
        "dead_time": motor.dead_time / motor.T_s,
    }
    assert LEAST_TORQUE <= motor.tau_rated <= MOST_TORQUE
    assert 2.0 * math.pi / (motor.omega_rated * motor.T_s) >= PERIODS
    for name, value in found.items():
        assert 0.998 * RANGES[name].low <= value <= 1.002 * RANGES[name].high, name
    psi = flux(motor.saturation, np.zeros((1, 2)))
    L = np.linalg.inv(inverse_inductance(motor.saturation, psi)[0])
    assert psi[0] == pytest.approx([motor.psi_f, 0.0], rel=1e-4, abs=1e-9)
    assert np.diag(L) == pytest.approx([motor.L_d, motor.L_q], rel=1e-4)
    line = operating_line(motor, True)
    need = float(np.interp(motor.tau_rated, torque(motor, line), np.hypot(*line.T)))
    low, high = RANGES["loading"].low, RANGES["loading"].high
    assert 0.99 * low * motor.i_rated < need < 1.01 * high * motor.i_rated


def test_no_shipped_machine_is_among_them(machines: tuple[Motor, ...]) -> None:
    shipped = [Motor.load(path.stem) for path in MOTORS.glob("*.toml")]
    assert len(shipped) >= 3
    for motor in machines:
        for held_out in shipped:
            ratios = [getattr(motor, x) / getattr(held_out, x) for x in ("R_s", "L_d", "psi_f")]
            assert max(abs(math.log(ratio)) for ratio in ratios) > 0.05


@pytest.mark.parametrize("index", FIRST)
def test_the_sensored_twin_loses_nothing(index: int, machines: tuple[Motor, ...]) -> None:
    """Whatever a schedule loses on these machines is not the control's fault."""
    motor = machines[index]
    run = rollout(
        make_policy("sensored", motor),
        suite("stress-1", motor, 3, 8, "tune"),
        Alone(motor, DriveDesign()),  # it is its own twin
    )
    assert not run.lost.any()
