"""Where golden vectors are taken, and what drive they follow."""

import numpy as np
import pytest

from sensorless.baselines.linear import eq25_band, linear_table
from sensorless.core.api import Array
from sensorless.design.drive import DriveDesign
from sensorless.export.vectors import (
    as_words,
    drive_vectors,
    hex_words,
    places,
    table_vectors,
)
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import Axis, KsTable

SPEED, TORQUE = Axis("speed", 0.1, 0.5, 5), Axis("torque_current", -1.5, 1.5, 4)


def of(words: Array) -> Array:
    return np.ascontiguousarray(words).view(np.float32)


def test_lookups_are_at_edges_nodes_middles_and_where_no_number_belongs() -> None:
    at = places(KsTable((SPEED, TORQUE), np.zeros((5, 4), dtype=np.float32)))
    corners, inside, odd = at[:25], at[25:57], at[57:]
    assert len(odd) == 14
    wanted = [[0.1, 0.1, 0.2, 0.3, 0.5], [-1.5, -1.5, -0.5, 0.0, 1.5]]
    pairs = [(a, b) for a in wanted[0] for b in wanted[1]]
    assert corners == pytest.approx(np.array(pairs))
    assert corners[5, 0] > corners[0, 0] and corners[1, 1] > corners[0, 1], "just above the edge"
    for j, (low, high) in enumerate(((0.1, 0.5), (-1.5, 1.5))):
        share = (inside[:, j] - low) / (high - low)
        assert -0.2 <= share.min() < 0.0 and 1.0 < share.max() <= 1.2
    strange = [np.inf, -np.inf, np.nan, 3.4e38, -3.4e38, 1e-41, -0.0]
    for j, middle in ((0, 0.0), (1, 0.3)):
        rows = odd[7 * j : 7 * j + 7]
        assert as_words(rows[:, j]).tolist() == as_words(np.array(strange, np.float32)).tolist()
        assert rows[:, 1 - j] == pytest.approx(np.full(7, middle))


def test_a_lookup_has_its_signals_and_its_weight() -> None:
    """A weight that falls from 1 to 0 over the axis, and stays beyond."""
    table = KsTable((SPEED,), np.linspace(1.0, 0.0, 5).astype(np.float32))
    found = of(table_vectors(table, "f32"))[:37]
    line = np.clip((0.5 - found[:, 0]) / 0.4, 0.0, 1.0)
    assert found[:, 1] == pytest.approx(line, abs=1e-6) and np.ptp(line) == 1.0


def test_words_are_bits_and_every_nan_is_alike() -> None:
    odd = np.array([0x7FC00001, 0xFFC00000], dtype=np.uint32).view(np.float32)
    words = as_words(np.r_[np.float32(1.0), np.float32(-2.0), odd])
    assert words[2] == words[3]
    assert hex_words(words[:2]) == "0x3F800000, 0xC0000000"


@pytest.mark.usefixtures("whole_run")
def test_the_drive_goes_through_the_band_and_back() -> None:
    """To 36 % of rated speed at twice rated speed a second, then to 10 %; weights by speed."""
    motor = Motor.load("paper")
    band = eq25_band(motor)
    found = drive_vectors(linear_table(*band), motor, DriveDesign(), 5)
    words = of(found.words)
    assert len(words) == 5000 and found.find == (0, 2500)
    rated = motor.n_p * motor.omega_m_rated
    for t, share in ((0.1, 0.0), (0.24, 0.2), (0.5, 0.36), (0.75, 0.26), (0.99, 0.1)):
        assert words[round(t / motor.T_s), 3] / rated == pytest.approx(share, abs=2e-3), t
    assert words[0, 2] == pytest.approx(motor.u_dc, rel=0.02)
    k_s_ref = words[:, 4]
    assert set(np.flatnonzero(np.diff(k_s_ref)) % 5) == {4}, "a decision every fifth period"
    running = np.arange(700, 5000, 5)
    wanted = np.interp(words[running - 1, 8] / rated, band, [1.0, 0.0])
    assert np.median(np.abs(k_s_ref[running] - wanted)) < 0.02
    assert k_s_ref.min() == 0.0 and k_s_ref.max() == 1.0
    # half of rated torque brakes the shaft, at most as if nothing held against it
    before, after = (words[round(t / motor.T_s), 8] for t in (0.599, 0.61))
    fall = motor.n_p * 0.5 * motor.tau_rated / motor.J * 0.01
    assert 0.3 * fall < before - after < fall
    assert found.start == (0.0, 0.0, 1.0)
