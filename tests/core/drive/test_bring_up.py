"""The check of a drive's installation, on pulses whose answer is known in closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest

from sensorless.core.api import Array, ffi, lib, pointer
from sensorless.core.bring_up import FAULTS, WIRINGS
from sensorless.design.records import bring_up_record
from sensorless.export.faults import DO
from sensorless.identify.bring_up.words import CURE
from sensorless.machine.motor import Motor, Saturation

SWAP_AB = np.array([[-0.5, 0.75**0.5], [0.75**0.5, 0.5]])
"""Phases a and b exchanged, alpha-beta: worked out by hand from Clarke's matrix."""


class Coil:
    """A salient winding at rest, L di/dt = u - R i - lost sign(i), which the check runs on."""

    def __init__(self, params: Array, theta: float, R: float = 0.0, lost: float = 0.0) -> None:
        self.p = pointer(params, "bring_up_params_t[]")
        self.x = ffi.new("bring_up_state_t *")
        lib.bring_up_init(self.x)
        record = params[0]
        ratio = (1.0 + record["anisotropy"]) / (1.0 - record["anisotropy"])
        turn = np.array([[math.cos(theta), -math.sin(theta)], [math.sin(theta), math.cos(theta)]])
        inverse = np.diag([1.0 / record["L_d"], 1.0 / (ratio * record["L_d"])])
        self.gain = float(record["T_s"]) * turn @ inverse @ turn.T
        self.R, self.lost = R, lost

    def run(self, delay: int = 1, sensor: Array | None = None, volts: float = 1.0) -> Array:
        """Until the check is done; returns the currents (n, 2)."""
        sensor = np.eye(2) if sensor is None else sensor
        i, waiting, out = np.zeros(2), [np.zeros(2)] * delay, []
        while self.x.phase != lib.BRING_UP_DONE:
            out.append(i)
            a, b = sensor @ i
            u = lib.bring_up_step(self.p, self.x, a, -0.5 * a + 0.75**0.5 * b)
            waiting.append(volts * np.array([u.a, u.b]))
            i = i + self.gain @ (waiting.pop(0) - self.drop(i))
        return np.array(out)

    def drop(self, i: Array) -> Array:
        """Voltage that resistance and dead time take [V]."""
        size = float(np.hypot(*i))
        return self.R * i + (self.lost * i / size if size > 0.0 else 0.0 * i)

    @property
    def faults(self) -> set[str]:
        return {name for name, bit in FAULTS.items() if self.x.fault & bit}


@pytest.fixture
def params(motor: Motor) -> Array:
    return bring_up_record(motor).reshape(1)


@pytest.mark.parametrize("theta", np.linspace(-3.0, 3.0, 7))
def test_it_measures_a_winding(params: Array, theta: float) -> None:
    """Resistance and lost voltage are the coil's; the loss is that of all legs along d."""
    record = params[0]
    along = 2.0 / 3.0 * sum(abs(math.cos(theta - k * 2.094395)) for k in range(3))
    lost = float(record["u_lost"]) * along
    coil = Coil(params, theta, float(record["R_s"]), lost)
    coil.run()
    assert not coil.faults and WIRINGS[coil.x.wiring] == "right"
    assert coil.x.delay == 1.0
    assert coil.x.scale == pytest.approx(1.0, abs=0.03)
    assert coil.x.lost == pytest.approx(1.0, abs=0.1)
    assert coil.x.R_s == pytest.approx(float(record["R_s"]), rel=0.25)


@pytest.mark.parametrize(("high", "low"), [(1.0, 1.0), (0.8, 0.9)])
def test_levels_at_which_iron_saturates(params: Array, high: float, low: float) -> None:
    """What the same falls tell where the d axis has other inductances at the levels; by hand."""
    record = params[0]
    record["L_high"], record["L_low"] = high * record["L_d"], low * record["L_d"]
    coil = Coil(params, 0.0, float(record["R_s"]), float(record["u_lost"]) * 4.0 / 3.0)
    coil.run()
    x, cycles = coil.x, int(record["n_cycles"])
    held, risen = cycles * (int(record["n_hold"]) - 1), cycles * (int(record["n_push"]) - 1)
    i = np.array(list(x.level)) / held
    k_volts = -np.array(list(x.fall)) / held * [high, low]  # k (lost + R i) at both levels
    k_R = (k_volts[0] - k_volts[1]) / (i[0] - i[1])
    k_lost = k_volts[0] - k_R * i[0]
    k = (x.rise / risen + k_lost + k_R * x.level_rise / risen) / float(record["u_push"])
    assert x.R_s == pytest.approx(k_R / k, rel=1e-3)
    assert x.scale == pytest.approx(k * record["L_d"] / record["T_s"], rel=1e-4)
    assert x.lost == pytest.approx(k_lost / k / (4.0 / 3.0 * record["u_lost"]), rel=1e-3)


@pytest.mark.parametrize("delay", [0, 2, 3])
def test_another_delay(params: Array, delay: int) -> None:
    coil = Coil(params, 0.7)
    coil.run(delay=delay)
    assert coil.faults == {"delay"} and coil.x.delay == pytest.approx(delay)


def test_wrong_wiring(params: Array) -> None:
    """Also with every current inverted on top, and where no wiring explains the currents."""
    for sensor, faults, wiring in (
        (-np.eye(2), {"sign"}, "right"),
        (SWAP_AB, {"phases"}, "swapped_ab"),
        (-SWAP_AB, {"phases", "sign"}, "swapped_ab"),
        (np.diag([1.0, -1.0]), {"phases"}, "swapped_bc"),
        (np.diag([1.0, 0.0]), {"wiring"}, "unknown"),
    ):
        coil = Coil(params, 0.4)
        coil.run(sensor=sensor)
        assert coil.faults == faults and WIRINGS[coil.x.wiring] == wiring


def test_wrong_scale_and_a_driver_that_compensates(params: Array) -> None:
    for volts in (0.5, 0.75, 1.3, 2.0):
        coil = Coil(params, 1.1)
        coil.run(volts=volts)
        assert coil.faults == {"scale"} and coil.x.scale == pytest.approx(volts, rel=0.02)
    coil = Coil(params, 1.1, float(params[0]["R_s"]))
    coil.run()
    assert coil.faults == {"dead_time"} and abs(coil.x.lost) < 0.05


def test_it_stops_before_harm(params: Array) -> None:
    """Too much current, no number, a shaft that turns, and a motor that is not there."""
    for i_a, fault in ((1e3, "current"), (math.nan, "current"), (0.4, "moves"), (0.0, "deaf")):
        coil = Coil(params, 0.0)
        for _ in range(1000):
            u = lib.bring_up_step(coil.p, coil.x, i_a, 0.0)
            if coil.x.phase == lib.BRING_UP_DONE:
                break
        assert coil.faults == {fault} and (u.a, u.b) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("name", "value"),
    [("c", 1e6), ("c", math.nan), ("s", -1e9), ("phase", 77), ("phase", -1), ("n", -(2**30))],
)
def test_damage_to_its_state_ends_it_without_voltage(
    params: Array, name: str, value: float
) -> None:
    """A d axis that is no direction would be a voltage; a wrong count, a check without end."""
    coil = Coil(params, 0.7)
    coil.x.phase = lib.BRING_UP_PUSH
    setattr(coil.x.d if name in "cs" else coil.x, name, value)
    u = lib.bring_up_step(coil.p, coil.x, 0.0, 0.0)
    assert coil.x.phase == lib.BRING_UP_DONE and (u.a, u.b) == (0.0, 0.0)
    assert coil.faults == {"state"}


def test_the_currents_have_no_mean_and_stay_small(params: Array, motor: Motor) -> None:
    """So the rotor is not turned away, whatever its angle."""
    i = Coil(params, 0.9).run()
    assert np.abs(i.mean(axis=0)).max() < 0.01 * motor.i_rated
    assert np.hypot(*i.T).max() < 0.7 * motor.i_rated


def test_pole_pairs_are_turns_over_turns() -> None:
    """Either way round, across the seam."""
    for way in (1.0, -1.0):
        count = ffi.new("turn_count_t *")
        angles = way * np.linspace(0.0, 3 * 2.0 * np.pi * 1.02, 400)
        lib.turn_begin(count, 0.0)
        for angle in np.angle(np.exp(1j * angles)):
            lib.turn_count(count, angle)
        assert lib.turn_pole_pairs(count, -1.02) == 3


def test_a_check_that_was_not_begun_says_so(params: Array) -> None:
    """Static memory is zero: without ``bring_up_init`` nothing has been checked."""
    x = ffi.new("bring_up_state_t *")
    lib.bring_up_step(pointer(params, "bring_up_params_t[]"), x, 0.0, 0.0)
    assert x.phase == lib.BRING_UP_DONE and x.fault == lib.BRING_UP_FAULT_STATE


def turning_shaft(params: Array, motor: Motor, speed: float) -> set[str]:
    """Faults on a shaft that something turns at a share of rated speed, without dead time."""
    coil, psi, theta = Coil(params, 0.0), np.array([motor.psi_f, 0.0]), 0.0
    waiting = [np.zeros(2)]
    inverse = coil.gain / motor.T_s
    while coil.x.phase != lib.BRING_UP_DONE:
        c, s = math.cos(theta), math.sin(theta)
        turn = np.array([[c, -s], [s, c]])
        i = turn @ inverse @ (turn.T @ psi - np.array([motor.psi_f, 0.0]))
        u = lib.bring_up_step(coil.p, coil.x, i[0], -0.5 * i[0] + 0.75**0.5 * i[1])
        waiting.append(np.array([u.a, u.b]))
        psi = psi + motor.T_s * (waiting.pop(0) - motor.R_s * i)
        theta += motor.T_s * speed * motor.omega_rated
    return coil.faults


def test_a_shaft_that_turns_slowly_shows_as_a_scale(params: Array, motor: Motor) -> None:
    """Too slow for the current at rest: what the bit asks to do names the shaft, too."""
    assert turning_shaft(params, motor, 0.0) <= {"dead_time"}
    assert turning_shaft(params, motor, 0.2) == {"moves"}
    found = turning_shaft(params, motor, 0.04)
    assert found == {"scale"}
    for name in found:
        assert "shaft" in CURE[name] and "shaft" in DO[f"BRING_UP_FAULT_{name.upper()}"]


LEGS = np.array([[1.0, 0.0], [-0.5, 0.75**0.5], [-0.5, -(0.75**0.5)]])
"""Phase currents of alpha and beta."""


class Legs(Coil):
    """A winding on an inverter whose legs lose a voltage each, against their current."""

    lost: float

    def drop(self, i: Array) -> Array:
        """Voltage that resistance and legs take [V]."""
        size = float(self.p[0].i_rest)
        return self.R * i + 2.0 / 3.0 * LEGS.T @ (self.lost * np.tanh(LEGS @ i / (0.1 * size)))


@pytest.mark.parametrize("share", [0.25, 1.0, 1.5])
def test_a_right_drive_that_loses_much_voltage_is_not_flagged(share: float) -> None:
    """A fifth of the probe's pulses goes to dead time; the bound has room for what that turns."""
    spindle = replace(
        Motor.load("paper"), name="spindle", n_p=2, R_s=0.15, L_d=3e-4, L_q=5.5e-4, psi_f=0.0566,
        J=4e-4, B=0.0, tau_rated=3.0, i_rated=18.4, n_rated_rpm=14000.0, u_dc=325.0, T_s=5e-5,
        u_inj=30.0, i_max=27.0, i_trip=55.0, dead_time=1e-6, adc_range=60.0,
        saturation=Saturation.linear(3e-4, 5.5e-4, 0.0566),
    )  # fmt: skip
    record = bring_up_record(spindle).reshape(1)
    assert record["lopsided"] > 0.1
    turned, wrong = 0, 0
    for theta in np.linspace(0.0, math.pi, 36, endpoint=False):
        coil = Legs(record, theta, spindle.R_s, share * spindle.dead_time_voltage)
        coil.run()
        assert not coil.faults and WIRINGS[coil.x.wiring] == "right", theta
        tight = record.copy()
        tight["lopsided"] = 0.06
        coil = Legs(tight, theta, spindle.R_s, share * spindle.dead_time_voltage)
        coil.run()
        turned += bool(coil.faults)
        coil = Legs(record, theta, spindle.R_s, share * spindle.dead_time_voltage)
        coil.run(sensor=np.array([[2.0, 0.0], [0.0, 1.0]]))
        wrong += bool(coil.faults)
    assert (turned > 0) == (share >= 1.0), "what the bound is for"
    assert wrong > 20, "a channel with twice its gain, at most angles"
