"""The corrections of the sliding-mode observer that slide: signum and super-twisting."""

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from sensorless.core.api import lib, pointer, struct_dtype
from sensorless.design.records import control_record
from sensorless.machine.motor import Motor
from sensorless.observers.smo_design import SWITCHING, super_twisting
from tests.helpers.smo_steady import ESTIMATE, EXACT, STATE, Call, angles, linear, params


def test_sign_chatters_and_sigmoid_does_not(c: Call, motor: Motor) -> None:
    """Signum: the model current jumps by up to 2 T_s (k + E) / L_d; sigmoid: it stays still."""
    ideal = linear(motor)
    p = params(ideal, k=400.0)
    smooth, small = angles(c, ideal, p, 300.0, 1e-3 + 0j)
    p["switching"] = lib.SMO_SIGN
    rough, big = angles(c, ideal, p, 300.0, 1e-3 + 0j)
    emf = motor.rpm_to_electrical(300.0) * motor.psi_f
    assert np.ptp(big) > 1.0
    assert np.ptp(big) <= 2.1 * motor.T_s / motor.L_d * (400.0 + emf)
    assert np.ptp(small) < 0.5
    assert np.ptp(rough) > 20.0 * np.ptp(smooth)


@pytest.mark.parametrize("i", [1e-3 + 0j, -0.6 + 1.8j])
@pytest.mark.parametrize("rpm", [150.0, 600.0, 1500.0])
@pytest.mark.parametrize(("switching", "order"), [("sign", 1), ("super_twisting", 2)])
def test_order_of_the_sliding(
    c: Call, motor: Motor, switching: str, order: int, rpm: float, i: complex
) -> None:
    """Sliding of order r keeps the current error within T_s^r: halving T_s shows which it is.

    Levant, Int. J. Control 58 (1993) 1247, doi 10.1080/00207179308923053.
    """
    swings = []
    for ratio in (1, 2, 4):
        fast = replace(linear(motor), T_s=motor.T_s / ratio)
        p = params(fast, k=2.5 * fast.omega_rated * fast.psi_f)
        p["switching"] = SWITCHING[switching]
        error, x = angles(c, fast, p, rpm, i, periods=1500 * ratio)
        swings.append(np.ptp(x))
        if switching == "super_twisting":
            assert abs(np.mean(error)) < 1.0 / ratio
            assert np.ptp(error) < 2.0 / ratio**2
    for coarse, fine in pairwise(swings):
        assert 2.0 ** (order - 0.5) < coarse / fine < 2.0 ** (order + 0.5)


@pytest.mark.parametrize("name", ["paper", "ipmsm_2200w", "pmsyrm_5600w"])
def test_super_twisting_covers_the_change_of_the_emf(name: str) -> None:
    """k_2 exceeds the fastest change of an EMF of k at rated speed; k_1 belongs to it."""
    motor = Motor.load(name)
    k = 2.0 * motor.omega_rated * motor.psi_f
    root, climb = super_twisting(motor, k)
    t = np.linspace(0.0, 2.0 * math.pi / motor.omega_rated, 10001)
    steepest = np.max(np.abs(np.gradient(k * np.sin(motor.omega_rated * t), t)))
    assert climb * motor.omega_rated**2 == pytest.approx(1.1 * steepest, rel=1e-4)
    bound = root * motor.omega_rated / 1.5
    assert bound**2 == pytest.approx(motor.L_d * steepest, rel=1e-4)


def test_super_twisting_in_one_period(c: Call, motor: Motor) -> None:
    """z = k_1 |x|^½ sign(x) + v per axis, v moved on by T_s k_2 sign(x) and held within k."""
    p = params(motor, k=300.0)
    p["switching"], p["root"], p["climb"] = lib.SMO_SUPER_TWISTING, 0.5, 2e-3
    omega, rest = 100.0, np.zeros(2, np.float32)
    x, y = np.zeros(1, dtype=STATE), np.zeros(1, dtype=ESTIMATE)
    x["v"]["a"], x["v"]["b"], x["i_hat"]["a"], x["i_hat"]["b"] = 299.0, 40.0, 0.25, -0.09
    p["R_s"] = 0.0
    c("smo_observe", p, x, y, rest, rest, motor.L_q, omega, 0.0, motor.T_s)
    assert x["v"]["a"][0] == 300.0
    assert x["v"]["b"][0] == pytest.approx(40.0 - 2e-3 * omega**2)
    assert x["z"]["a"][0] == pytest.approx(300.0 + 0.5 * omega * 0.5, rel=1e-5)
    assert x["z"]["b"][0] == pytest.approx(20.0 - 0.5 * omega * 0.3, rel=1e-5)


def test_a_fresh_drive_remembers_nothing(motor: Motor) -> None:
    """Whatever stood in its memory."""
    record = np.array(control_record(motor, EXACT)).reshape(1)
    x = np.zeros(1, dtype=struct_dtype("drive_state_t"))
    for name in ("i_hat", "z", "v"):
        x["smo"][name]["a"] = x["smo"][name]["b"] = np.nan
    at = pointer(record, "drive_params_t[]"), pointer(x, "drive_state_t[]")
    lib.drive_init(*at, 0.1, 50.0, 1.0)
    assert all(x["smo"][name][axis][0] == 0.0 for name in ("i_hat", "z", "v") for axis in "ab")
    assert x["smo"]["omega_f"][0] == 50.0
