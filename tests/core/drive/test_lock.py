"""The tests of core/drive/lock.h against closed forms."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from sensorless.core.api import Array, lib, struct_dtype
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.machine_family import family
from sensorless.machine.magnetics import flux, mtpa
from sensorless.machine.motor import MOTORS, Motor

Call = Callable[..., None]

MOTOR = Motor.load("paper")
PARAMS = control_record(MOTOR, DriveDesign(estimator="smo"))["lock"]
E_RATED = MOTOR.omega_rated * MOTOR.psi_f
MACHINES = [
    *map(Motor.load, sorted(path.stem for path in MOTORS.glob("*.toml"))),
    *family(7207, 64),
]


def evaluate(c: Call, rows: Any) -> Array:
    """State after these rows of ``t_lock``, for a drive that began at the speed of the first."""
    state = np.zeros(1, dtype=struct_dtype("lock_state_t"))
    state["omega"] = rows[0][0]
    inputs = np.ascontiguousarray(rows, dtype=np.float32)
    c("lock", PARAMS.reshape(1).copy(), state, inputs, len(inputs))
    (row,) = state
    return np.asarray(row)


def without_current(share: float, delta: float, estimated: float | None = None) -> list[float]:
    """A rotor at ``share`` of rated speed that is ``delta`` [rad] ahead, seen at ``estimated``."""
    omega = MOTOR.omega_rated * (share if estimated is None else estimated)
    u_d, u_q = -share * E_RATED * np.sin(delta), share * E_RATED * np.cos(delta)
    return [omega, u_d, u_q, 0.0, 0.0, MOTOR.L_d, MOTOR.L_q, MOTOR.psi_f, MOTOR.psi_f, 0.0,
            0.0, 0.0]  # fmt: skip


@pytest.mark.parametrize("delta", [0.0, 30.0, 60.0, 90.0, 180.0])
@pytest.mark.parametrize("share", [-1.0, 0.1, 0.5, 1.0])
def test_the_residual_is_what_the_angle_takes_from_the_emf(
    c: Call, share: float, delta: float
) -> None:
    x = evaluate(c, [without_current(share, np.deg2rad(delta))] * 100)
    expected = share * E_RATED * (np.cos(np.deg2rad(delta)) - 1.0)
    assert x["residual"] == pytest.approx(expected, abs=1e-4 * E_RATED)
    assert x["emf"] == pytest.approx(abs(share) * E_RATED, rel=1e-4)
    beside = -share * E_RATED * np.sin(np.deg2rad(delta))
    assert x["across"] == pytest.approx(beside, abs=1e-4 * E_RATED)


@pytest.mark.parametrize(
    ("share", "delta", "told"),
    [(1.0, 0, False), (1.0, 45, False), (1.0, 75, True), (-1.0, 75, True), (0.3, 180, True),
     (0.05, 180, False)],
)  # fmt: skip
def test_which_angles_the_emf_tells(c: Call, share: float, delta: float, told: bool) -> None:
    """At rated speed those beyond 60 degrees and the floor; at rest none."""
    x = evaluate(c, [without_current(share, np.deg2rad(delta))] * 100)
    assert x["alarm"] == told
    assert x["reason"] == (lib.LOCK_EMF if told else 0)


@pytest.mark.parametrize(
    ("share", "delta", "told"),
    [(0.35, 50, False), (0.35, 80, True), (0.35, -80, True), (-0.35, 80, True), (0.35, 85, True),
     (0.08, 80, False), (0.8, 58, False), (0.8, 68, True)],
)  # fmt: skip
def test_the_direction_tells_what_the_size_does_not(
    c: Call, share: float, delta: float, told: bool
) -> None:
    """The q part alone is within its bounds at these angles."""
    x = evaluate(c, [without_current(share, np.deg2rad(delta))] * 100)
    assert abs(x["residual"]) < PARAMS["e_share"] * x["emf"] + PARAMS["e_floor"]
    assert x["reason"] == (lib.LOCK_EMF if told else 0)


@pytest.mark.parametrize(
    ("share", "delta", "within"),
    [(0.3, 180, 0.03), (0.1, 180, 0.1), (0.04, 180, None), (0.15, 0, None), (-0.1, 180, 0.1)],
)
def test_half_a_turn_that_lasts_is_told_at_little_speed(
    c: Call, share: float, delta: float, within: float | None
) -> None:
    """r is -2 omega psi_f there, of which half the EMF and ``e_late`` are allowed."""
    every = float(1.0 / PARAMS["inv_t"])
    row = without_current(share, np.deg2rad(delta))
    n = round(1.0 / every)
    x = evaluate(c, [row] * n)
    left = max(abs(share) * E_RATED * ((1.0 - np.cos(np.deg2rad(delta))) - 0.5), 0.0)
    assert abs(x["late"]) == pytest.approx(left, abs=1e-3 * E_RATED)
    assert x["reason"] == (lib.LOCK_EMF if within else 0)
    if within:
        assert evaluate(c, [row] * round(within / every))["alarm"] == 1


def test_an_angle_that_turns_while_its_speed_stands(c: Call) -> None:
    """Injection holds the angle half a turn off a shaft at 5 % of rated, and the speed says 0."""
    every = float(1.0 / PARAMS["inv_t"])
    t = every * np.arange(round(0.5 / every))
    rows = np.array([without_current(0.05, np.pi, 0.0)] * len(t))
    for turns, told in ((0.0, False), (0.05, True)):
        rows[:, 10] = np.angle(np.exp(1j * turns * MOTOR.omega_rated * t))
        rows[:, 11] = every
        assert evaluate(c, rows)["reason"] == (lib.LOCK_EMF if told else 0)


@pytest.mark.parametrize("turns", [0, 1, -3, 40])
def test_turns_between_two_evaluations_are_the_speed_s(c: Call, turns: int) -> None:
    """A fast machine turns more than once from one to the next; its angle shows none of it."""
    every = float(1.0 / PARAMS["inv_t"])
    omega = 50.0 + 2.0 * np.pi * turns / every
    theta = np.angle(np.exp(1j * 50.0 * every * np.arange(300)))
    rows = np.zeros((300, 12))
    rows[:, 0], rows[:, 10], rows[:, 11] = omega, theta, every
    rows[:, 2], rows[:, 7] = omega * MOTOR.psi_f, MOTOR.psi_f
    assert abs(evaluate(c, rows)["late"]) < 2e-3 * E_RATED


@pytest.mark.parametrize(("lag", "told"), [(0.14, False), (-0.14, False), (0.3, True)])
def test_a_speed_that_lags_under_load_has_no_direction(c: Call, lag: float, told: bool) -> None:
    """At standstill under rated current d shows what an error of speed makes of L_q i_q."""
    i_q = MOTOR.i_rated * np.minimum(np.arange(100) / 50.0, 1.0)
    behind = lag * MOTOR.omega_rated
    rows = np.array([without_current(0.0, 0.0)] * 100)
    rows[:, 1], rows[:, 4] = behind * MOTOR.L_q * i_q, i_q
    slope = np.diff(i_q, prepend=0.0) * PARAMS["inv_t"]
    rows[:, 2] = MOTOR.R_s * i_q + MOTOR.L_q * slope
    x = evaluate(c, rows)
    assert x["across"] == pytest.approx(behind * MOTOR.L_q * i_q[-1], rel=1e-3)
    assert x["reason"] == (lib.LOCK_EMF if told else 0)


def test_an_estimate_that_turns_while_the_rotor_stands(c: Call) -> None:
    for true, estimated in ((0.0, 0.5), (0.5, 0.0)):
        x = evaluate(c, [without_current(true, 0.0, estimated)] * 100)
        assert x["reason"] == lib.LOCK_EMF


def test_half_a_turn_is_told_within_ten_milliseconds(c: Call) -> None:
    every = 1.0 / PARAMS["inv_t"]
    rows = [without_current(0.6, np.pi)] * round(float(0.010 / every))
    assert evaluate(c, rows)["alarm"] == 1


@pytest.mark.parametrize(("delta", "told"), [(0.0, False), (20.0, False), (50.0, True)])
def test_a_speed_that_no_shaft_reaches_is_told_and_the_steepest_ramp_is_not(
    c: Call, delta: float, told: bool
) -> None:
    """One and a half times rated torque on half the inertia; besides, 60 degrees in 16 ms.

    With an EMF that agrees the shaft is that fast: its inertia is less than the file's.
    """
    steepest = 3.0 * MOTOR.n_p * MOTOR.tau_rated / MOTOR.J
    every = float(1.0 / PARAMS["inv_t"])
    slips = steepest + np.pi / 3.0 / 16e-3 / 4e-3
    for slope, fast in ((steepest, False), (-steepest, False), (1.25 * slips, True)):
        t = every * np.arange(60)
        shares = slope * t / MOTOR.omega_rated
        rows = np.array([without_current(x, np.deg2rad(delta)) for x in shares])
        assert evaluate(c, rows)["reason"] == (lib.LOCK_SPEED if fast and told else 0)


@pytest.mark.parametrize("motor", MACHINES, ids=lambda m: m.name)
def test_a_shaft_that_stands_leaves_more_than_an_emf_that_agrees(motor: Motor) -> None:
    """An estimate that turns alone leaves omega psi_d on the q, omega L_q i_q on the d axis.

    Here over the EMF of the auxiliary flux, which counts up to twice that of the d axis.
    """
    i = mtpa(motor)[1:]
    psi, psi_0 = (flux(motor.saturation, x) for x in (i, i * [0.0, 1.0]))
    psi_a = psi[:, 0] - psi[:, 1] / i[:, 1] * i[:, 0]
    left = np.abs(psi).max(axis=1) / np.minimum(psi_a, 2.0 * psi_0[:, 0])
    assert left.min() > 0.6  # LOCK_AGREES is 0.4


def test_a_slip_of_half_a_turn_in_ten_milliseconds_is_told(c: Call) -> None:
    """At rest, where no EMF tells it: the estimate's speed has to make up for the half turn."""
    every = float(1.0 / PARAMS["inv_t"])
    n = round(0.01 / every)
    speed = np.concatenate([np.zeros(20), np.pi / (0.5 * n * every) * np.hanning(n), np.zeros(20)])
    rows = np.array([without_current(0.0, 0.0)] * len(speed))
    rows[:, 0] = speed
    rows[:, 5:9] = 0.0  # nothing for the EMF
    assert evaluate(c, rows)["alarms"] == 1


def test_a_current_that_misses_its_reference(c: Call) -> None:
    for off, told in ((0.9, False), (-0.9, False), (1.1, True), (-1.1, True)):
        rows = np.array([without_current(0.0, 0.0)] * 100)
        rows[:, 9] = off * PARAMS["i_off"]
        assert evaluate(c, rows)["reason"] == (lib.LOCK_CURRENT if told else 0)


def test_a_ramp_of_the_current_is_no_residual(c: Call) -> None:
    """L di/dt is taken off on both axes: a slope of rated current in 20 ms."""
    slope = MOTOR.i_rated / 0.02
    rows = np.array([without_current(0.0, 0.0)] * 60)
    for u, i, L in ((1, 3, MOTOR.L_d), (2, 4, MOTOR.L_q)):
        rows[:, i] = slope / PARAMS["inv_t"] * np.arange(1, 61)
        rows[:, u] = L * slope + MOTOR.R_s * rows[:, i]
    x = evaluate(c, rows)
    assert abs(x["residual"]) < 0.01 * MOTOR.L_q * slope
    assert abs(x["across"]) < 0.01 * MOTOR.L_d * slope


def test_a_drive_that_takes_control_has_a_grace(c: Call) -> None:
    """Its currents settle first; a counter out of its range gives none."""
    grace, every = int(PARAMS["n_grace"]), float(1.0 / PARAMS["inv_t"])
    assert 0.015 < grace * every < 0.05
    begun = struct_dtype("lock_state_t")
    for start, told in ((65536 + grace, False), (2**31 - 1, True)):
        state = np.zeros(1, dtype=begun)
        state["bad"] = start
        rows = np.array([without_current(1.0, np.pi)] * grace, dtype=np.float32)
        c("lock", PARAMS.reshape(1).copy(), state, rows, len(rows))
        assert state["alarm"][0] == told


def test_an_alarm_lasts_as_long_as_its_cause(c: Call) -> None:
    """After 65 s too, when its counter comes to where that of the grace begins."""
    state = np.zeros(1, dtype=struct_dtype("lock_state_t"))
    rows = np.array([without_current(1.0, np.pi)] * 40, dtype=np.float32)
    c("lock", PARAMS.reshape(1).copy(), state, rows, len(rows))
    assert state["alarm"][0] == 1
    state["bad"] = 65536 - 5
    for _ in range(10):
        c("lock", PARAMS.reshape(1).copy(), state, rows[:1].copy(), 1)
        assert state["alarm"][0] == 1
