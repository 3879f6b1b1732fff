"""No input, however bad, makes the controller produce a NaN; each leaves its fault bit."""

import math

import numpy as np
import pytest

from sensorless.core.api import lib
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.motor import MOTORS, Motor
from tests.helpers.controller import GOOD, Drive

CURRENT, U_DC, OVER = lib.FAULT_CURRENT, lib.FAULT_U_DC, lib.FAULT_OVER_CURRENT
COMMAND, POLE = lib.FAULT_COMMAND, lib.FAULT_POLE
MACHINES = sorted(path.stem for path in MOTORS.glob("*.toml"))
DENORMAL = 1e-42
WILD = [math.nan, math.inf, -math.inf, 3e38, -3e38, DENORMAL, -DENORMAL, 1e30, 0.0, -0.0]


def test_good_inputs_set_no_fault(motor: Motor) -> None:
    """A healthy drive stays healthy; only that no machine answers may show, as lost lock."""
    drive = Drive(motor)
    for _ in range(500):
        assert all(map(math.isfinite, drive.step()))
    assert drive.x["fault"][0] & ~lib.FAULT_LOCK == 0


@pytest.mark.parametrize(
    ("field", "value", "bit"),
    [
        ("i_a", math.nan, CURRENT),
        ("i_b", math.inf, CURRENT),
        ("i_a", -11.1, CURRENT),
        ("i_b", 11.1, CURRENT),
        ("i_a", 9.9, OVER | CURRENT),
        ("i_b", -9.9, OVER | CURRENT),
        ("u_dc", math.nan, U_DC),
        ("u_dc", -5.0, U_DC),
        ("u_dc", math.inf, U_DC),
        ("u_dc", 1e6, U_DC),
        ("u_dc", 0.49 * 540.0, U_DC),
        ("u_dc", 1.51 * 540.0, U_DC),
        ("omega_ref", math.nan, COMMAND),
        ("omega_ref", -math.inf, COMMAND),
        ("omega_ref", 1e7, COMMAND),
        ("omega_ref", -2.51 * 314.16, COMMAND),
        ("k_s_ref", math.nan, COMMAND),
        ("k_s_ref", 1.01, COMMAND),
        ("k_s_ref", -0.01, COMMAND),
    ],
)
def test_fault_bits(motor: Motor, field: str, value: float, bit: int) -> None:
    """A bad value sets exactly its bit, which stays; the drive goes on with numbers."""
    drive = Drive(motor)
    drive.step()
    assert all(map(math.isfinite, drive.step(**{field: value})))
    assert drive.x["fault"][0] == bit
    for _ in range(50):
        assert all(map(math.isfinite, drive.step()))
    assert drive.x["fault"][0] == bit
    assert np.all(np.isfinite(drive.numbers()))


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_reference_beyond_the_bound_is_followed_up_to_it(motor: Motor, way: float) -> None:
    """A throttle that asks for a little more must not brake the shaft to rest."""
    drive, most = Drive(motor), float(control_record(motor, DriveDesign())["guard"]["omega"])
    at_bound = Drive(motor)
    for _ in range(50):
        assert drive.step(omega_ref=1.2 * way * most) == at_bound.step(omega_ref=way * most)
    assert drive.x["fault"][0] == COMMAND
    assert at_bound.x["fault"][0] == 0


@pytest.mark.parametrize("field", list(GOOD))
@pytest.mark.parametrize("value", WILD)
def test_lasting_bad_input(motor: Motor, field: str, value: float) -> None:
    """Even hundreds of periods of the same bad value leave every number of the state finite."""
    drive = Drive(motor)
    for _ in range(300):
        assert all(map(math.isfinite, drive.step(**{field: value})))
    assert np.all(np.isfinite(drive.numbers()))


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("seek", [False, True])
def test_random_bit_patterns(motor: Motor, seed: int, seek: bool) -> None:
    """Inputs of arbitrary bits: outputs stay finite and bounded by the voltage limit."""
    rng = np.random.default_rng(seed)
    drive = Drive(motor, omega=rng.uniform(-300.0, 300.0), seek=seek)
    words = rng.integers(0, 2**32, (4000, len(GOOD)), dtype=np.uint32).view(np.float32)
    for row in words:
        chosen = rng.random(len(GOOD)) < 0.7
        bad = {name: float(v) for name, v, use in zip(GOOD, row, chosen, strict=True) if use}
        u = drive.step(**bad)
        assert all(map(math.isfinite, u))
        assert np.all(np.isfinite(drive.numbers()))
    assert drive.x["fault"][0] & ~(POLE | OVER | lib.FAULT_LOCK) == CURRENT | U_DC | COMMAND


@pytest.mark.parametrize("value", WILD)
def test_the_start_sequence_ends_on_any_input(motor: Motor, value: float) -> None:
    """Currents that are no numbers: the sequence comes to its end with its fault bits."""
    drive = Drive(motor, seek=True)
    for _ in range(300):
        assert all(map(math.isfinite, drive.step(i_a=value, i_b=value)))
    assert drive.x["start"]["phase"][0] == lib.START_DONE
    assert np.all(np.isfinite(drive.numbers()))


def test_largest_plausible_inputs(motor: Motor) -> None:
    """Values just inside of the limits, in the worst combinations, do not overflow either."""
    rng = np.random.default_rng(9)
    drive = Drive(motor)
    for _ in range(3000):
        signs = rng.choice([-1.0, 1.0], 3)
        u = drive.step(
            i_a=10.9 * signs[0],
            i_b=10.9 * signs[1],
            u_dc=1.49 * motor.u_dc,
            omega_ref=2.39 * motor.omega_rated * signs[2],
            k_s_ref=float(rng.integers(0, 2)),
        )
        assert all(map(math.isfinite, u))
    assert drive.x["fault"][0] & ~lib.FAULT_LOCK == OVER | CURRENT
    assert np.all(np.isfinite(drive.numbers()))


@pytest.mark.parametrize("name", MACHINES)
def test_limits_follow_the_machine(name: str) -> None:
    """Above what the control asks for, at or below what is measured and what trips."""
    m = Motor.load(name)
    g = control_record(m, DriveDesign())["guard"]
    assert m.i_max < math.sqrt(g["i_over_sq"]) <= 1.0001 * min(m.i_trip, m.adc_range)
    assert m.adc_range < g["i_sample"] < 1.2 * m.adc_range
    assert 0.4 * m.u_dc < g["u_dc_min"] < 0.8 * m.u_dc < 1.3 * m.u_dc < g["u_dc_max"] < 2 * m.u_dc
    assert 2.0 * m.omega_rated < g["omega"] <= 1e5


def test_over_current_is_that_of_the_vector(motor: Motor) -> None:
    """No phase need reach the limit; a current just below it in every direction sets nothing."""
    limit = 0.98 * motor.adc_range
    for at in np.linspace(-math.pi, math.pi, 25):
        for share, fault in ((0.999, 0), (1.001, OVER)):
            drive, i = Drive(motor), share * limit
            drive.params["guard"]["i_step_sq"] = np.inf
            drive.step(i_a=i * math.cos(at), i_b=i * math.cos(at - 2.0 * math.pi / 3.0))
            assert drive.x["fault"][0] == fault, (at, share)


@pytest.mark.parametrize("estimator", ["coupled", "smo", "flux"])
@pytest.mark.parametrize("seek", [False, True])
def test_samples_move_as_far_as_voltage_drives_them(
    motor: Motor, estimator: str, seek: bool
) -> None:
    """4/3 of the link at 115 % on L_d, in every direction, between any two samples in control."""
    limit = 1.15 * 4.0 / 3.0 * motor.u_dc * motor.T_s / motor.L_d
    for at in np.linspace(-math.pi, math.pi, 13):
        step = limit * np.array([math.cos(at), math.cos(at - 2.0 * math.pi / 3.0)])
        drive = Drive(motor, seek=seek, estimator=estimator)
        for share in (0.4, -0.58, 0.41, -0.7):
            drive.step(i_a=share * step[0], i_b=share * step[1])
            told = not seek and share == -0.7
            assert drive.x["fault"][0] == (CURRENT if told else 0), (at, share)


@pytest.mark.parametrize(
    ("amplitude", "omega"), [(67.0, -700.0), (140.0, -948.0), (9e3, 950.0), (2e3, 1400.0)]
)
def test_model_current_does_not_run_away(motor: Motor, amplitude: float, omega: float) -> None:
    """Currents beyond the reach of the sliding-mode correction do not let its model grow."""
    drive = Drive(motor, omega)
    drive.params["guard"]["i_sample"] = 1e4
    for k in range(6000):
        turn = omega * motor.T_s * k + math.pi * (k // 40 % 2)
        a, b = (amplitude * math.cos(turn - lag) for lag in (0.0, 2.0 * math.pi / 3.0))
        assert all(map(math.isfinite, drive.step(i_a=a, i_b=b, k_s_ref=0.0, omega_ref=omega)))
        assert abs(float(drive.x["smo"]["i_hat"]["a"][0])) < 2.0 * amplitude + 50.0


def test_recovers(motor: Motor) -> None:
    """After a burst of bad samples the angle of a standing drive is still an angle in range."""
    drive = Drive(motor, omega=0.0)
    for k in range(400):
        drive.step(i_a=math.nan if k % 3 else 0.5, omega_ref=0.0)
    for _ in range(2000):
        drive.step(i_a=0.0, i_b=0.0, omega_ref=0.0)
    assert abs(float(drive.x["est"]["theta"][0])) <= math.pi * (1 + 1e-6)
    assert abs(float(drive.x["est"]["omega"][0])) <= 2.5 * motor.omega_rated
