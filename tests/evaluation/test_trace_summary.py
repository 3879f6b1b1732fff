"""The rows of a summary, of runs that are written by hand."""

from typing import Any

import numpy as np
import pytest

from sensorless.evaluation.trace import Trace
from sensorless.evaluation.trace_summary import plateaus, summary_table
from sensorless.units import RPM_TO_RAD_S

T_S = 1e-3
TIME = np.arange(1000) * T_S
TARGET = np.where(TIME < 0.4999, 500.0, 600.0)
"""Two plateaus of half a second [r/min]."""


def run(**columns: Any) -> Trace:
    """A drive that follows its target, but for these columns; speeds in r/min."""
    zero, never = np.zeros(len(TIME)), np.zeros(len(TIME), dtype=bool)
    speed = RPM_TO_RAD_S * columns.pop("speed", TARGET)
    names = ("tau", "tau_load", "k_s", "theta_e_err", "starting", "lost")
    return {
        **dict.fromkeys(names, zero),
        **dict.fromkeys(("judged", "alarm", "not_held", "twin_swings"), never),
        "t": TIME,
        "omega_m_ref": RPM_TO_RAD_S * TARGET,
        "omega_m": speed,
        "omega_m_twin": speed,
        **columns,
    }


def test_a_speed_beyond_its_target_overshoots_by_a_share_of_the_step() -> None:
    """10 r/min of 100, for 50 ms."""
    _, row = plateaus(run(speed=np.where((TIME > 0.4999) & (TIME < 0.5499), 610.0, TARGET)))
    assert row["overshoot_pct"] == pytest.approx(10.0)
    assert row["settled_s"] == pytest.approx(0.05)


def test_a_speed_that_settles_for_the_last_tenth_alone_has_not() -> None:
    """It is off for 460 and for 440 of 500 ms."""
    for off, settled in ((0.96, False), (0.94, True)):
        speed = np.where((TIME > 0.4999) & (TIME < off - 1e-4), 610.0, TARGET)
        _, row = plateaus(run(speed=speed))
        assert np.isfinite(row["settled_s"]) == settled


def test_the_steady_end_of_a_plateau_is_its_last_200_ms() -> None:
    """A weight of 1 until 250 and 150 ms before the end: none, and a quarter, of that is left."""
    for until, mean in ((0.7499, 0.0), (0.8499, 0.25)):
        _, row = plateaus(run(k_s=np.where(TIME < until, 1.0, 0.0)))
        assert row["k_s"] == pytest.approx(mean)


def swinging() -> Trace:
    """By 0.1 N m at 50 Hz, one cycle in 20 ms, on a ramp of 3 N m a second."""
    return run(tau=0.1 * np.sin(2.0 * np.pi * 50.0 * TIME) + 3.0 * TIME)


def test_ripple_is_about_the_mean_in_the_middle_of_which_it_is() -> None:
    """One at the end of its 20 ms would lag by 10 ms, 0.03 N m of the ramp."""
    _, row = plateaus(swinging())
    rms = 0.1 / np.sqrt(2.0) * np.cos(np.pi * 50.0 * T_S)  # of means of two samples
    assert row["torque_ripple_nm"] == pytest.approx(rms, rel=0.01)


def test_the_table_has_the_ripple_in_percent_of_rated_torque() -> None:
    """0.0698 N m of 2."""
    cells = list(summary_table(swinging(), "eq25", 2.0).columns[-1].cells)
    assert cells[-1] == "3.49"
