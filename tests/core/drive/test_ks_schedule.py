"""Table or built-in rule: what the target does with a good table, a bad one and bad signals."""

from typing import Any

import numpy as np
import pytest

from sensorless.core.api import ffi, lib, pointer
from sensorless.table.ks_table import Axis, KsTable

RULE = (0.2, 0.3)
TABLE = KsTable((Axis("speed", 0.1, 0.5, 2),), np.array([0.9, 0.1], dtype=np.float32), fallback=0.6)


class Schedule:
    """``ks_schedule_*`` on a speed signal of 1 per rad/s."""

    def __init__(self, periods: int = 1, motor_hash: int = 9, **changes: Any) -> None:
        self.header = TABLE.record(motor_hash=9).reshape(1)
        for name, value in changes.items():
            self.header[name] = value
        self.values = TABLE.stored()
        self.params = ffi.new("ks_schedule_params_t *")
        self.params.table = pointer(self.header, "ks_table_t[]")
        self.params.values = pointer(self.values, "char[]")
        self.params.motor_hash, self.params.periods = motor_hash, periods
        self.params.rule.x_min, self.params.rule.x_max = RULE
        self.state = ffi.new("ks_schedule_state_t *")
        self.signal = ffi.new("signal_params_t *", {"inv_omega": 1.0})
        self.found = lib.ks_schedule_init(self.params, self.state)

    def __call__(self, speed: float) -> float:
        x = ffi.new("signal_state_t *", {"omega": speed})
        return float(lib.ks_schedule_step(self.params, self.state, self.signal, x))


def test_a_good_table_decides() -> None:
    schedule = Schedule()
    assert schedule.found == lib.KS_OK
    assert schedule(-0.3) == pytest.approx(0.5)
    assert schedule.state.fault == 0


def test_a_decision_holds_for_its_periods() -> None:
    schedule = Schedule(periods=3)
    weights = [schedule(speed) for speed in (0.1, 0.5, 0.5, 0.5, 0.1, 0.1, 0.1)]
    assert weights == pytest.approx([0.9, 0.9, 0.9, 0.1, 0.1, 0.1, 0.9])


@pytest.mark.parametrize(
    ("changes", "found"),
    [
        ({"crc_header": 1}, "CRC"),
        ({"fallback": 0.5}, "CRC"),
        ({"format": 2}, "FORMAT"),
        ({"policy_hash": 8}, "CRC"),
        ({"magic": 0}, "MAGIC"),
    ],
)
def test_a_refused_table_gives_the_rule_and_a_fault(changes: dict[str, Any], found: str) -> None:
    schedule = Schedule(**changes)
    assert schedule.found == getattr(lib, f"KS_BAD_{found}")
    for speed in np.linspace(-0.5, 0.5, 41):
        expected = np.clip((RULE[1] - abs(speed)) / (RULE[1] - RULE[0]), 0.0, 1.0)
        assert schedule(speed) == pytest.approx(expected, abs=1e-6)
    assert schedule.state.fault == lib.KS_FAULT_TABLE


def test_the_table_of_another_motor_is_refused() -> None:
    schedule = Schedule(motor_hash=10)
    assert schedule.found == lib.KS_BAD_MOTOR
    assert schedule.state.fault == lib.KS_FAULT_TABLE


@pytest.mark.parametrize("missing", ["table", "values"])
def test_no_table_gives_the_rule_and_a_fault(missing: str) -> None:
    schedule = Schedule()
    setattr(schedule.params, missing, ffi.NULL)
    assert lib.ks_schedule_init(schedule.params, schedule.state) == lib.KS_BAD_MAGIC
    assert schedule(0.25) == pytest.approx(0.5, abs=1e-5)
    assert schedule.state.fault == lib.KS_FAULT_TABLE


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_bad_signal_gives_the_fallback_and_a_fault(bad: float) -> None:
    schedule, refused = Schedule(), Schedule(crc_header=1)
    assert schedule(bad) == pytest.approx(0.6)
    assert schedule.state.fault == lib.KS_FAULT_INPUT
    assert refused(bad) == 1.0
    assert refused.state.fault == lib.KS_FAULT_TABLE | lib.KS_FAULT_INPUT
    assert schedule(0.3) == pytest.approx(0.5)  # the next good signal counts again
    assert schedule.state.fault == lib.KS_FAULT_INPUT  # what happened stays known


@pytest.mark.parametrize("speed", [3.4e38, -3.4e38, 1e-44])
def test_huge_and_tiny_speeds_give_a_weight(speed: float) -> None:
    for schedule in (Schedule(), Schedule(crc_header=1)):
        assert 0.0 <= schedule(speed) <= 1.0
        assert not schedule.state.fault & lib.KS_FAULT_INPUT


@pytest.mark.parametrize("wait", [2**31 - 1, 4, -1, -(2**31)])
def test_a_damaged_counter_decides_at_once(wait: int) -> None:
    schedule = Schedule(periods=3)
    schedule(0.1)
    schedule.state.wait = wait
    assert schedule(0.5) == pytest.approx(0.1)


@pytest.mark.parametrize("bit", range(31))
def test_a_damaged_check_gives_the_rule_and_a_fault(bit: int) -> None:
    schedule = Schedule()
    schedule.state.check ^= 1 << bit
    assert schedule(0.25) == pytest.approx(0.5, abs=1e-5)
    assert schedule.state.fault == lib.KS_FAULT_TABLE


def test_a_table_that_was_never_checked_does_not_decide() -> None:
    """Static memory is zero: without ``ks_schedule_init`` the rule decides, and says so."""
    schedule = Schedule(fallback=0.5)
    schedule.state = ffi.new("ks_schedule_state_t *")
    assert schedule(0.25) == pytest.approx(0.5, abs=1e-5)
    assert schedule.state.fault == lib.KS_FAULT_TABLE
