"""What the drive learns of its current sensors, against errors that are known and closed forms."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, lib, pointer, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.evaluation.evaluate import score
from sensorless.machine.motor import Motor, Saturation
from sensorless.observers.coupled_design import damping
from sensorless.observers.flux_design import standstill_rate
from sensorless.observers.match_design import (
    GAIN,
    GAIN_SPEED,
    OFFSET,
    design_match,
    injection_swing,
    learning_times,
)
from sensorless.policies.registry import make_policy

MOTORS = (
    "paper", "ipmsm_2200w", "pmsyrm_5600w", "pmsrm_15kw", "brusa_hsm1", "ebike_hub", "formula_wheel"
)  # fmt: skip
GAINS = np.array([[1.02, 0.99], [0.985, 1.01]])
"""Channels a and b of two drives."""
SHARES = np.array([[0.004, -0.003], [-0.002, 0.005]])
"""Their offsets over rated current."""


def drives(
    motor: Motor, speed: float, load: float, *, gains: Array, shares: Array, carrier: bool = False
) -> Array:
    """Drives at a share of rated speed and torque, settled; their weight is 0."""
    n = len(gains)
    s = Scenarios.nominal(motor, np.arange(n, dtype=np.uint64), 10.0)
    s.omega_0[:] = speed * motor.omega_rated / motor.n_p
    s.omega[:] = s.omega_0[:, None]
    s.tau[:] = load * motor.tau_rated
    s.tau_rate[:] = 10.0 * motor.tau_rated
    s.gain, s.offset = gains, shares * motor.i_rated
    sims = SimFactory(motor, DriveDesign(carrier=carrier)).build(s, twin=False)
    run(sims, motor, 0.2)
    return sims


def run(sims: Array, motor: Motor, seconds: float, k_s: float = 0.0) -> None:
    """Advance all drives."""
    obs = np.zeros((len(sims), SIGNAL_N), dtype=np.float32)
    sim_run(sims, round(seconds / motor.T_s), np.full(len(sims), k_s, dtype=np.float32), obs)
    assert not sims["lost"].any()


def learned(sims: Array) -> Array:
    """(n, 3): half the difference of the gains, offsets of the channels [A]."""
    x = sims["drive"]["x"]["coupled"]["match"]
    return np.stack([x["gain"], x["offset_a"], x["offset_b"]], axis=1).astype(float)


def true(motor: Motor, gains: Array, shares: Array) -> Array:
    """The same of the sensors."""
    a, b = motor.i_rated * shares.T
    return np.stack([0.5 * (gains[:, 0] - gains[:, 1]), a, b], axis=1)


@pytest.mark.parametrize("name", MOTORS)
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_known_errors_are_found_at_rated_speed(name: str, way: float) -> None:
    motor = Motor.load(name)
    sims = drives(motor, 0.9 * way, 0.6, gains=GAINS, shares=SHARES)
    run(sims, motor, 1.5)
    off = learned(sims) - true(motor, GAINS, SHARES)
    size = np.array([GAIN, OFFSET * motor.i_rated, OFFSET * motor.i_rated])
    assert np.abs(off / size).max() < 0.2


def test_known_errors_are_found_with_a_carrier(motor: Motor) -> None:
    sims = drives(motor, 0.9, 0.6, gains=GAINS, shares=SHARES, carrier=True)
    run(sims, motor, 1.5)
    off = learned(sims) - true(motor, GAINS, SHARES)
    size = np.array([GAIN, OFFSET * motor.i_rated, OFFSET * motor.i_rated])
    assert np.abs(off / size).max() < 0.25


def test_the_gain_converges_as_its_gradient_says(motor: Motor) -> None:
    """Mean of the gradient over a turn: k g^2 / 2, seen through flux correction and mean."""
    linear = Saturation.linear(motor.L_d, motor.L_q, motor.psi_f)
    motor = replace(motor, saturation=linear)
    sims = drives(motor, 1.0, 0.8, gains=np.ones((1, 2)), shares=np.zeros((1, 2)))
    x, p = sims["drive"]["x"], sims["control"]["coupled"]
    rest = learned(sims)[0, 0]
    x["coupled"]["match"]["gain"] += 0.01
    t = 0.06
    run(sims, motor, t)
    left = (learned(sims)[0, 0] - rest) / 0.01

    i = x["control"]["i"]
    i_d, i_q = float(i["d"][0]), float(i["q"][0])
    L_q = 0.85 * motor.L_q
    aux = motor.psi_f + (motor.L_d - L_q) * i_d, (L_q - motor.L_d) * i_q
    square = aux[0] ** 2 + aux[1] ** 2
    slope = 2.0 / math.sqrt(3.0) * math.hypot(i_d, i_q)
    slope *= math.hypot(motor.L_d * aux[0], L_q * aux[1]) / square
    w = motor.omega_rated
    s = 2j * w
    rate = 2.0 * (standstill_rate(motor) + damping(motor) * w)
    seen = (s**2 + w**2) / (s**2 + rate * s + w**2) * s / (s + GAIN_SPEED * w)
    per_second = float(p["match"]["k_gain"][0]) / learning_times(motor)[0]
    assert left == pytest.approx(math.exp(-per_second * 0.5 * slope**2 * seen.real * t), abs=0.06)


def test_perfect_sensors_stay_perfect(motor: Motor) -> None:
    sims = drives(motor, 0.9, 0.6, gains=np.ones((1, 2)), shares=np.zeros((1, 2)))
    run(sims, motor, 1.0)
    size = np.array([GAIN, OFFSET * motor.i_rated, OFFSET * motor.i_rated])
    assert np.abs(learned(sims) / size).max() < 0.12


def test_below_its_speeds_nothing_is_learned(motor: Motor) -> None:
    sims = drives(motor, 0.9, 0.6, gains=GAINS, shares=SHARES)
    kept = learned(sims)
    slow = drives(motor, 0.9 * GAIN_SPEED, 0.6, gains=GAINS, shares=SHARES)
    assert not learned(slow).any()
    slow["drive"]["x"]["coupled"]["match"] = sims["drive"]["x"]["coupled"]["match"]
    run(slow, motor, 0.5)
    assert np.array_equal(learned(slow), kept)


def test_large_errors_are_bounded(motor: Motor) -> None:
    sims = drives(motor, 0.9, 0.6, gains=np.array([[1.1, 0.9]]), shares=np.array([[0.04, 0.04]]))
    run(sims, motor, 1.0)
    p = sims["control"]["coupled"]["match"]
    most = np.array([p["gain_max"][0], p["offset_max"][0], p["offset_max"][0]])
    assert (np.abs(learned(sims)) <= most).all()
    assert learned(sims)[0, 0] > 0.95 * most[0]


def test_a_new_start_keeps_them_and_an_initial_state_does_not(motor: Motor) -> None:
    sims = drives(motor, 0.9, 0.6, gains=GAINS[:1], shares=SHARES[:1])
    x, p = (sims["drive"]["x"].copy(), sims["control"].copy())
    before = x["coupled"]["match"].copy()
    lib.drive_find_rotor(pointer(x, "drive_state_t[]"))
    assert np.array_equal(x["coupled"]["match"], before)
    lib.drive_init(pointer(p, "drive_params_t[]"), pointer(x, "drive_state_t[]"), 0.0, 0.0, 1.0)
    assert not any(np.asarray(x["coupled"]["match"][name]).view(np.float32).any()
                   for name in ("gain", "offset_a", "offset_b", "mean"))  # fmt: skip


def test_other_estimators_take_samples_as_they_are(motor: Motor) -> None:
    for estimator in ("smo", "flux"):
        s = Scenarios.nominal(motor, np.arange(1, dtype=np.uint64), 1.0)
        s.omega_0[:] = 0.5 * motor.omega_rated / motor.n_p
        s.omega[:], s.gain = s.omega_0[:, None], GAINS[:1]
        sims = SimFactory(motor, DriveDesign(estimator=estimator)).build(s, twin=False)
        run(sims, motor, 0.3)
        assert not learned(sims).any()


def test_too_little_saliency_learns_no_offset(motor: Motor) -> None:
    L_q = 1.05 * motor.L_d
    flat = replace(motor, L_q=L_q, saturation=Saturation.linear(motor.L_d, L_q, motor.psi_f))
    rates = {"flux_bandwidth": 280.0, "injection": 50.0, "correction": 120.0}
    assert design_match(flat, **rates)["k_offset"] == 0.0
    assert design_match(motor, **rates)["k_offset"] > 0.0


def test_what_injection_makes_of_a_gain(motor: Motor) -> None:
    """The rotor frame's flux error e under a correction c towards an angle that swings at 2 w.

    de/dt = -(c + j w) e + j c psi sin(2 w t): its real part, by integration.
    """
    w, W, c = GAIN_SPEED * motor.omega_rated, 50.0, 120.0
    turned = 2.0 / math.sqrt(3.0) / (1.0 - motor.L_d / motor.L_q)
    h, e, along = 2.0 * math.pi / w / 4000, 0j, []
    for k in range(12 * 4000):
        e = e * np.exp(-(c + 1j * w) * h) + 1j * c * h * np.sin(2.0 * w * h * k)
        along.append(e.real)
    swing = max(along[-4000:]) * turned * W / math.hypot(W, w)
    assert injection_swing(motor, W, c) == pytest.approx(swing, rel=0.01)


SERVO = replace(
    Motor.load("paper"), name="servo", n_p=5, R_s=0.1, L_d=167e-6, L_q=184e-6, psi_f=0.01326,
    J=3e-5, B=4e-5, tau_rated=1.27, i_rated=13.0, n_rated_rpm=3000.0, u_dc=48.0, T_s=62.5e-6,
    u_inj=9.6, i_max=19.5, i_trip=39.0, dead_time=0.5e-6, adc_range=26.0,
    u_transistor=0.0, u_diode=0.0,
    saturation=Saturation.linear(167e-6, 184e-6, 0.01326),
)  # fmt: skip
"""400 W at 3000 r/min from a datasheet, with L_q / L_d = 1.1."""


@pytest.mark.parametrize("motor", [SERVO, Motor.load("formula_wheel")], ids=lambda m: m.name)
def test_injection_does_not_lead_a_gain_astray(motor: Motor) -> None:
    """Both sensors are exact; learned under injection, the gain ran to its bound."""
    found = []
    for alone in (1.0, 0.0):
        sims = drives(motor, 0.24, 0.0, gains=np.ones((2, 2)), shares=np.zeros((2, 2)))
        assert np.all(sims["control"]["coupled"]["match"]["alone"] == 1.0)
        sims["control"]["coupled"]["match"]["alone"] = alone
        sims["err_limit"] = 7.0
        run(sims, motor, 2.0, k_s=1.0)
        found.append(float(np.abs(learned(sims)[:, 0]).max()))
    assert found[0] < 0.1 * GAIN and found[1] > GAIN


def test_a_servo_with_little_saliency_keeps_its_rotor() -> None:
    """104 hand-overs of a drive that knows its machine: 19 % of more were lost."""
    rows = SuiteRows("handoff", SERVO, 3, 104)
    assert not score(make_policy("eq25", SERVO), rows, SimFactory(SERVO, DriveDesign())).lost.any()


@pytest.mark.parametrize("name", ["paper", "ipmsm_2200w"])
def test_where_injection_s_sign_alternates_the_gain_is_learned_with_it(name: str) -> None:
    motor = Motor.load(name)
    sims = drives(motor, 0.3, 0.6, gains=GAINS, shares=0.0 * SHARES)
    assert np.all(sims["control"]["coupled"]["match"]["alone"] == 0.0)
    run(sims, motor, 1.5, k_s=1.0)
    off = learned(sims) - true(motor, GAINS, 0.0 * SHARES)
    assert np.abs(off[:, 0]).max() < 0.35 * GAIN
