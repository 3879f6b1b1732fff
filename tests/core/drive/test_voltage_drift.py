"""What the voltage model gets wrong, learned from the injection: docs/coupled-learning.md."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from sensorless.core.api import Array, struct_dtype
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.motor import Motor

Call = Callable[..., None]
Floats = NDArray[np.float64]
DEAD, RES, IND, EVEN, LOSS, TURN = range(6)
MACHINES = ("paper", "pmsyrm_5600w", "brusa_hsm1", "formula_wheel", "ebike_hub")


def zeta(motor: Motor) -> float:
    """Damping of the flux error, as the observer has it."""
    return float(control_record(motor, DriveDesign())["coupled"]["gain_w"]) / motor.T_s


def params(motor: Motor) -> Array:
    """``drift_params_t``, shape (1,)."""
    return np.array(control_record(motor, DriveDesign())["coupled"]["drift"]).reshape(1)


class Learned:
    """Rows (n, 6) of the drifts, voltage lost, turn, for errors of the injection [rad]."""

    def __init__(self, c: Call, motor: Motor) -> None:
        self.c, self.p = c, params(motor)
        self.x = np.zeros(1, dtype=struct_dtype("drift_state_t"))
        c("drift_clear", self.p, self.x)

    def run(
        self,
        err: Floats,
        i_q: Floats | float,
        omega: float = 0.0,
        *,
        k_s: float = 1.0,
        every: int = 1,
    ) -> Floats:
        """Go on for the errors (n,) with torque current [A] and electrical speed [rad/s]."""
        n = len(err)
        out = np.zeros((n, 6), dtype=np.float32)
        columns = (np.broadcast_to(y, n).astype(np.float32) for y in (err, i_q, omega))
        self.c("drift", self.p, self.x, *columns, k_s, every, out, n)
        return out.astype(np.float64)


def settle(learned: Learned, motor: Motor, sign: float = 1.0) -> None:
    """Let the torque current's low-passed sign settle at rated current, with nothing to learn."""
    learned.run(np.zeros(20 * round(1.0 / float(learned.p["alpha"][0]))), sign * motor.i_rated)
    assert learned.x["sign"][0] == pytest.approx(sign, rel=1e-3)
    learned.x["sign"] = sign  # in float32 its low-pass ends some 1e-5 short of it


@pytest.mark.parametrize("name", MACHINES)
def test_without_steady_torque_nine_tenths_of_the_loss_count(c: Call, name: str) -> None:
    """A loss that counts as too large feeds a swing of the current about zero."""
    motor = Motor.load(name)
    learned = Learned(c, motor)
    u_dt = float(learned.p["u_dt"][0])
    assert learned.run(np.zeros(5), 0.0)[-1, LOSS] == pytest.approx(0.9 * u_dt)
    settle(learned, motor)
    assert learned.run(np.zeros(1), motor.i_rated)[-1, LOSS] == pytest.approx(u_dt)
    swing = motor.i_rated * np.where(np.arange(400) % 2, 1.0, -1.0)
    assert learned.run(np.zeros(400), swing)[-1, LOSS] == pytest.approx(0.9 * u_dt, rel=0.01)


@pytest.mark.parametrize("share", [0.3, 1.0])
@pytest.mark.parametrize("speed", [0.0, 0.1, 0.2, 0.5])
@pytest.mark.parametrize("name", MACHINES)
def test_under_torque_voltages_and_inductances_take_all(
    c: Call, name: str, speed: float, share: float
) -> None:
    """One integrator of the injection's error; lost voltage and turn add up to its value."""
    motor = Motor.load(name)
    learned = Learned(c, motor)
    settle(learned, motor)
    k, u_dt = float(learned.p["k"][0]), float(learned.p["u_dt"][0])
    err = np.full(50, 0.1 * float(learned.p["res_most"][0]) / (50 * k))
    out = learned.run(err, share * motor.i_rated, speed * motor.omega_rated)
    total = k * np.cumsum(err)
    rise = min(speed / 0.2, 1.0)
    known = float(learned.p["ind_0"][0])
    odd = out[:, DEAD] + share * (out[:, RES] + rise * (out[:, IND] - known))
    assert odd == pytest.approx(total, rel=1e-3)
    assert np.abs(out[:, EVEN]).max() < 1e-3 * total[-1]
    by_loss = (u_dt - out[:, LOSS]) * 4.0 / 3.0 / motor.psi_f
    assert out[:, TURN] + by_loss - share * rise * known == pytest.approx(total, rel=1e-3, abs=5e-6)


@pytest.mark.parametrize("speed", [0.0, 0.1, 0.2, 0.5])
@pytest.mark.parametrize("share", [0.2, 0.5, 1.0])
def test_the_causes_share_by_their_variances(
    c: Call, motor: Motor, share: float, speed: float
) -> None:
    """Paper's motor: v = U_dc t_d/T_s/psi_f; half of R_s i/psi_f; half of omega L_q i/psi_f.

    The last two at the present current, the last to a fifth of rated speed.
    """
    learned = Learned(c, motor)
    known = float(learned.p["ind_0"][0])
    settle(learned, motor)
    out = learned.run(np.full(40, 1e-3), share * motor.i_rated, speed * motor.omega_rated)[-1]
    i = share * motor.i_rated / motor.psi_f
    omega = min(speed, 0.2) * motor.omega_rated
    v = motor.u_dc * motor.dead_time / motor.T_s / motor.psi_f
    causes = np.array([v, 0.5 * motor.R_s * i, 0.5 * omega * motor.L_q * i])
    drifts = out[DEAD], share * out[RES], share * min(speed / 0.2, 1.0) * (out[IND] - known)
    assert drifts / np.sum(drifts) == pytest.approx(
        causes**2 / np.sum(causes**2), rel=1e-3, abs=1e-6
    )
    lost = (float(learned.p["u_dt"][0]) - out[LOSS]) * 4.0 / 3.0 / motor.psi_f
    assert lost == pytest.approx(out[DEAD], rel=1e-3)


def test_currents_of_several_sizes_tell_dead_time_from_resistance(c: Call, motor: Motor) -> None:
    """The error is what is left of a drift by both; the load changes at random, ten a second."""
    learned = Learned(c, motor)
    v = motor.u_dc * motor.dead_time / motor.T_s / motor.psi_f
    true = np.array([-0.4 * v, 0.2 * motor.R_s * motor.i_rated / motor.psi_f])
    out = np.zeros(6)
    rng = np.random.default_rng(5)
    steps = round(0.1 / motor.T_s / 100)
    for load in rng.uniform(0.1, 1.0, 300):
        for _ in range(steps):  # injection turns the flux back in proportion to what is left
            left = true[0] - out[DEAD] + load * (true[1] - out[RES])
            out = learned.run(np.full(100, 1e-2 * left), load * motor.i_rated)[-1]
    assert out[[DEAD, RES]] == pytest.approx(true, abs=0.05 * np.abs(true).max())


def test_a_reversal_of_torque_turns_the_flux_the_other_way_at_once(c: Call, motor: Motor) -> None:
    learned = Learned(c, motor)
    settle(learned, motor)
    before = learned.run(np.full(100, 1e-3), motor.i_rated)[-1]
    after = learned.run(np.zeros(1), -motor.i_rated)[0]
    counts = 0.9 + 0.1 * (1.0 - 2.0 * float(learned.p["alpha"][0])) ** 2
    assert after[LOSS] == pytest.approx(counts * before[LOSS], rel=1e-6)
    turns = before[TURN] - (1.0 - counts) * before[LOSS] * 4.0 / 3.0 / motor.psi_f
    assert after[TURN] == pytest.approx(-turns, rel=1e-4) and before[TURN] > 0.0


@pytest.mark.parametrize("omega", [0.0, 50.0])
def test_a_load_that_goes_takes_its_drifts_along(c: Call, motor: Motor, omega: float) -> None:
    """Without torque current nothing turns the flux that was learned of a load at rated current."""
    learned = Learned(c, motor)
    settle(learned, motor)
    before = learned.run(np.full(100, 1e-3), motor.i_rated, omega)[-1]
    after = learned.run(np.zeros(1), 0.0, omega)[0]
    assert abs(after[TURN]) < 1e-3 * abs(before[TURN])


@pytest.mark.parametrize("swinging", [False, True])
def test_without_torque_the_even_drift_takes_all(c: Call, motor: Motor, swinging: bool) -> None:
    """The swing is ten times as fast as the low-pass of the sign, and the error swings with it."""
    learned = Learned(c, motor)
    n = 2000
    period = 2.0 * np.pi / float(learned.p["alpha"][0]) / 10.0
    swing = swinging * np.sign(np.sin(2.0 * np.pi * np.arange(n) / period))
    err = 1e-5 + 2e-5 * swing
    out = learned.run(err, motor.i_rated * swing)
    by_torque = abs(out[-1, DEAD]) + abs(out[-1, RES])
    assert by_torque < (0.2 if swinging else 1e-6) * out[-1, EVEN]
    assert out[-1, EVEN] > 0.7 * float(learned.p["k"][0]) * err.sum()


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_without_injection_the_even_drift_fades(c: Call, motor: Motor, share: float) -> None:
    """By 63 % in 1 / Omega, the double pole of the injection; under torque it stays."""
    learned = Learned(c, motor)
    even = learned.run(np.full(2000, 1e-5), 0.0)[-1, EVEN]
    settle(learned, motor, share)
    kept = learned.run(np.zeros(1), share * motor.i_rated)[-1, EVEN]
    assert kept == pytest.approx(even, rel=1e-4 if share == 0.0 else 0.5)
    n = round(1.0 / float(learned.p["alpha"][0]))
    after = learned.run(np.zeros(n), share * motor.i_rated, k_s=0.0)[-1, EVEN]
    assert after == pytest.approx(kept * (math.exp(-1.0) if share == 0.0 else 1.0), rel=0.02)


def test_errors_between_two_uses_are_not_lost(c: Call, motor: Motor) -> None:
    """Learning in every fifth period adds up the errors of all five."""
    err = np.random.default_rng(3).normal(0.0, 1e-3, 1000)
    each, fifth = (Learned(c, motor).run(err, 0.0, every=n)[:, EVEN] for n in (1, 5))
    assert fifth[4::5] == pytest.approx(each[4::5], abs=1e-6 * np.abs(each).max() + 1e-7)


@pytest.mark.parametrize("name", MACHINES)
def test_bounds(c: Call, name: str) -> None:
    """Whatever the injection says: a leg loses nothing to 1.5 times the file's dead time."""
    motor = Motor.load(name)
    for sign in (-1.0, 1.0):
        learned = Learned(c, motor)
        settle(learned, motor)
        out = learned.run(np.full(4000, sign), motor.i_rated)
        most = float(learned.p["most"][0])
        assert out[-1, DEAD] == pytest.approx(sign * most) and abs(out[-1, EVEN]) <= most
        quarter = 0.25 * motor.R_s * motor.i_rated / motor.psi_f
        assert 0.0 < sign * out[-1, RES] <= quarter * (1.0 + 1e-6)
        fast = learned.run(np.full(4000, sign), motor.i_rated, motor.omega_rated)
        fifth = 0.2 * motor.omega_rated * motor.L_q * motor.i_rated / motor.psi_f
        assert sign * fast[-1, IND] == pytest.approx(0.09 / (2.0 * zeta(motor)) * fifth)
        full = motor.u_dc * motor.dead_time / motor.T_s
        assert 0.0 <= out[-1, LOSS] <= 1.5 * full * (1.0 + 1e-6)


@pytest.mark.parametrize("speed", [0.05, 0.2, 0.8])
@pytest.mark.parametrize("name", MACHINES)
def test_the_low_inductance_is_known_from_the_start(c: Call, name: str, speed: float) -> None:
    """4.5 % of L_q: with phi of the flux, nu = -|omega| phi/(2 zeta), to a fifth of rated speed."""
    motor = Motor.load(name)
    learned = Learned(c, motor)
    settle(learned, motor)
    turn = learned.run(np.zeros(1), motor.i_rated, speed * motor.omega_rated)[0, TURN]
    phi = 0.045 * motor.L_q * motor.i_rated / motor.psi_f
    omega = min(speed, 0.2) * motor.omega_rated
    assert turn == pytest.approx(-omega * phi / (2.0 * zeta(motor)), rel=1e-4)


@pytest.mark.parametrize("bias", [0.3, 1.0, 1.5])
def test_what_is_known_stays_within_what_is_learned(motor: Motor, bias: float) -> None:
    record = control_record(motor, DriveDesign(coupled_L_q_bias=bias))["coupled"]["drift"]
    most = float(record["ind_most"])
    assert float(record["ind_0"]) == pytest.approx(np.sign(bias - 1.0) * most)


@pytest.mark.parametrize("name", MACHINES)
def test_trust_follows_from_dead_time_and_sensors(name: str) -> None:
    """Without current sensors' noise over dead time's, with a leg rarely at zero all of it."""
    motor = Motor.load(name)
    step = 2.0 * motor.adc_range / 2**motor.adc_bits
    share = 3.0 * step * motor.L_q / (motor.u_dc * motor.dead_time)
    p = params(motor)
    calm, rise = float(p["calm"][0]), float(p["calm_rise"][0])
    assert calm == pytest.approx(min(1.0, share), rel=1e-6)
    width = 8.0 / float(p["inv_i_true"][0]) / motor.i_rated
    assert calm + rise * width == pytest.approx(1.0, rel=1e-6)
    assert (calm < 1.0) == (name == "formula_wheel")


def test_trust_comes_with_the_torque_current(c: Call) -> None:
    """Of either sign, in periods that learn."""
    motor = Motor.load("formula_wheel")
    learned = Learned(c, motor)
    calm, rise = (float(learned.p[name][0]) for name in ("calm", "calm_rise"))
    assert float(learned.x["trust"][0]) == 1.0
    for share, every, expected in (
        (0.1, 10, 1.0), (0.0, 1, calm), (-0.1, 1, calm + 0.1 * rise), (0.8, 1, 1.0)
    ):  # fmt: skip
        learned.run(np.zeros(5), share * motor.i_rated, every=every)
        assert float(learned.x["trust"][0]) == pytest.approx(expected, rel=1e-6)


def test_without_dead_time_the_flux_is_always_trusted(motor: Motor) -> None:
    p = params(replace(motor, dead_time=0.0))
    assert float(p["calm"][0]) == 1.0 and float(p["calm_rise"][0]) == 0.0
