"""The schedule alone, in a drive that has its own observers."""

import numpy as np
import pytest

from sensorless.core.api import ffi, lib, pointer
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import Axis, KsTable, ValueFormat


class Hook:
    """Parameters and state of the hook for a table; scales of one: signals are themselves."""

    def __init__(self, table: KsTable, form: ValueFormat = "f32") -> None:
        self._header, self._values = table.record(form).reshape(1), table.stored(form)
        self.p, self.x = ffi.new("ks_hook_params_t *"), ffi.new("ks_hook_state_t *")
        self.p.schedule.table = pointer(self._header, "ks_table_t[]")
        self.p.schedule.values = pointer(self._values, "char[]")
        self.p.schedule.rule.x_min, self.p.schedule.rule.x_max = table.rule
        self.p.schedule.periods = 1
        signal = self.p.signal
        signal.alpha = signal.inv_omega = signal.inv_i = signal.alpha_per_s = 1.0
        self.p.k_s_step, self.p.omega_full, self.p.i_full = 1.0, 2.0, 4.0
        self.p.omega_most, self.p.i_most = 2.5, 5.0
        self.check = lib.ks_hook_init(self.p, self.x)

    def step(self, omega: float, i_q: float = 0.0, difference: float = 0.0) -> float:
        return float(lib.ks_hook_step(self.p, self.x, omega, i_q, difference))


@pytest.mark.parametrize("form", ["f32", "q15"])
def test_it_looks_up_what_the_drive_hands_over(form: ValueFormat, table: KsTable) -> None:
    """Against the table's own nodes; the current counts in the direction of motion."""
    hook = Hook(table, form)
    assert hook.check == lib.KS_OK
    for j, speed in enumerate(table.axes[0].nodes):
        for k, i_q in enumerate(table.axes[1].nodes):
            for way in (1.0, -1.0) if speed > 0.0 else (1.0,):
                k_s = hook.step(way * float(speed), way * float(i_q))
                assert abs(k_s - table.values[j, k]) < 2e-4


def test_q15_is_the_same_in_other_numbers(table: KsTable) -> None:
    """Within a step of the numbers; a weight of 1 is 0x7FFF exactly."""
    floats, words = Hook(table), Hook(table)
    rng = np.random.default_rng(3)
    for omega, i_q, angle in rng.integers(-32768, 32767, (300, 3)):
        unit = np.array([omega * 2.0, i_q * 4.0, angle * np.pi]) / 32768.0
        k_s = floats.step(*map(float, unit))
        found = lib.ks_hook_step_q15(words.p, words.x, int(omega), int(i_q), int(angle))
        assert abs(found - 32767.0 * k_s) <= 1.0
    assert lib.ks_hook_step_q15(words.p, words.x, 0, 0, 0) == round(32767 * words.x.k_s)


def test_a_hook_that_was_never_begun_says_so(table: KsTable) -> None:
    """Static memory is zero: without ``ks_hook_init`` the rule gives injection at rest."""
    hook = Hook(table)
    hook.x = ffi.new("ks_hook_state_t *")
    assert hook.step(0.0) == 1.0 and hook.x.schedule.fault == lib.KS_FAULT_TABLE


def test_the_slope_is_limited_and_signals_are_filtered(table: KsTable) -> None:
    hook = Hook(table)
    hook.p.k_s_step, hook.p.signal.alpha = 0.25, 0.5
    steps = [hook.step(1.0) for _ in range(12)]
    assert np.all(np.abs(np.diff([1.0, *steps])) <= 0.25 + 1e-6) and steps[-1] == 0.0
    assert hook.x.signal.omega == pytest.approx(1.0 - 0.5**12)


def test_bad_numbers_are_left_out(table: KsTable) -> None:
    """One after the other they change nothing but the fault bit, and nothing sticks."""
    hook = Hook(table)
    before = hook.step(0.1)
    for bad in (np.nan, np.inf, -np.inf, 10.0, -1e30, 3.4e38):
        for place in range(3):
            given = [0.1, 0.0, 0.0]
            given[place] = bad
            hook.x.schedule.fault = 0
            assert hook.step(*given) == before
            assert hook.x.schedule.fault == lib.KS_FAULT_INPUT
    assert hook.step(1.0) == 0.0


@pytest.mark.parametrize("bad", [np.nan, np.inf, -3.4e38, 1e30])
def test_a_damaged_state_heals_within_a_period(bad: float, table: KsTable) -> None:
    fresh = Hook(table)
    fresh.step(0.5, 0.3)
    for name in ("omega", "omega_2", "i_q", "disagree", "k_s"):
        hook = Hook(table)
        hook.step(0.5, 0.3)
        setattr(hook.x.signal, name, bad)
        hook.x.k_s = hook.x.schedule.k_s_ref = bad
        assert hook.step(0.5, 0.3) == fresh.step(0.5, 0.3)
        assert hook.x.schedule.fault == (0 if name == "k_s" else lib.KS_FAULT_INPUT)
        setattr(hook.x.signal, name, bad)
        assert 0.0 <= hook.step(np.nan) <= 1.0 and abs(hook.x.signal.omega) <= 2.5


def test_q15_numbers_are_held_to_the_same_bounds(table: KsTable) -> None:
    hook = Hook(table)
    hook.p.omega_most = 1.0  # half of the Q15 number 1
    assert lib.ks_hook_step_q15(hook.p, hook.x, 30000, 0, 0) == 32767
    assert hook.x.schedule.fault == lib.KS_FAULT_INPUT and hook.x.signal.omega == 0.0


def test_a_table_over_other_signals_is_refused() -> None:
    """The rule of the speed takes its place, as for a damaged table."""
    other = KsTable((Axis("emf", 0.0, 1.0, 2),), np.ones(2, dtype=np.float32))
    hook = Hook(other)
    assert hook.check == lib.KS_BAD_AXES and hook.x.schedule.fault == lib.KS_FAULT_TABLE
    assert hook.step(2.0) == 0.0 and hook.step(0.0) == 1.0


def test_the_drive_filters_the_same_way(motor: Motor) -> None:
    """``signals_filter`` is in both; a change of the drive's low-pass would show here."""
    record = control_record(motor, DriveDesign())["signal"]
    assert 0.0 < record["alpha"] < 1.0
    assert record["alpha_per_s"] * motor.T_s == pytest.approx(record["alpha"], rel=0.05)
