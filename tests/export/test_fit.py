"""Two thresholds that stand in for a table, and what they cost."""

import time
from pathlib import Path

import numpy as np
import pytest

from sensorless.baselines.constant import constant_table
from sensorless.baselines.linear import linear_table
from sensorless.design.drive import DriveDesign
from sensorless.export import fit as fitting
from sensorless.export.export import Exported, export
from sensorless.export.fit import fit, readme, two_threshold
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import Axis, KsTable
from tests.conftest import FULL_FIT


@pytest.mark.parametrize(("low", "high"), [(0.2, 0.4), (0.0, 0.1), (0.05, 1.0)])
def test_a_ramp_is_found_again(low: float, high: float, motor: Motor) -> None:
    rule = fit(linear_table(low, high), motor)
    assert rule is not None
    width, step = high - low, 1.25 * high / 1000.0
    rated = motor.n_rated_rpm
    assert np.allclose(np.array(rule.ramp) / rated, (low, high), atol=2e-4)
    quarters = (low + 0.25 * width, low + 0.75 * width)
    assert np.allclose(np.array(rule.hysteresis) / rated, quarters, atol=2.0 * step)
    assert rule.misfit < 1e-3


def test_low_torque_current_counts_most(motor: Motor) -> None:
    axes = (Axis("speed", 0.0, 0.5, 51), Axis("torque_current", -2.0, 2.0, 5))
    low = np.array([0.4, 0.3, 0.1, 0.3, 0.4])
    values = np.clip((low + 0.1 - axes[0].nodes[:, None]) / 0.1, 0.0, 1.0)
    rule = fit(KsTable(axes, values.astype(np.float32)), motor)
    assert rule is not None
    centre = np.mean(rule.ramp) / motor.n_rated_rpm
    assert 0.15 < centre < np.mean(low + 0.05)
    assert rule.misfit > 0.1


@pytest.mark.parametrize(
    "table",
    [
        constant_table(0.5),
        KsTable((Axis("speed", 0.0, 1.0, 2),), np.array([0.0, 1.0], dtype=np.float32)),
        KsTable((Axis("emf", 0.0, 1.0, 2),), np.array([1.0, 0.0], dtype=np.float32)),
    ],
)
def test_where_there_is_nothing_to_switch_none_is_given(
    table: KsTable, motor: Motor, design: DriveDesign
) -> None:
    entry = two_threshold(table, motor, design)
    assert entry == {"none": "k_s of this table does not fall with the speed"}
    assert readme(entry) == "There are none: k_s of this table does not fall with the speed."


@pytest.mark.parametrize(("end", "fitted"), [(0.48, True), (0.52, False)])
def test_a_fall_of_a_tenth_is_enough(end: float, fitted: bool, motor: Motor) -> None:
    values = np.array([0.6, end], dtype=np.float32)
    assert (fit(KsTable((Axis("speed", 0.0, 1.0, 2),), values), motor) is not None) == fitted


@pytest.mark.parametrize(("fall", "fitted"), [(0.05, False), (0.06, True)])
def test_a_node_counts_by_half_of_the_largest_magnitude_of_its_axis(
    fall: float, fitted: bool, motor: Motor
) -> None:
    """Weights exp(-4) and exp(-1): at -2, k_s falls by 1, at 1 by ``fall``: 0.047 + 0.953 fall."""
    axes = (Axis("speed", 0.0, 1.0, 2), Axis("torque_current", -2.0, 1.0, 2))
    values = np.array([[1.0, 0.5], [0.0, 0.5 - fall]], dtype=np.float32)
    assert (fit(KsTable(axes, values), motor) is not None) == fitted


def test_the_hard_switch_keeps_a_gap(motor: Motor) -> None:
    rule = fit(linear_table(0.3, 0.3001), motor)
    assert rule is not None
    down, up = rule.hysteresis
    assert up / down == pytest.approx(1.05 / 0.95, rel=1e-3)


@pytest.mark.usefixtures("without_selftest")
def test_the_folder_states_the_loss(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    table: KsTable,
    motor: Motor,
    design: DriveDesign,
) -> None:
    """On a third of the scenarios, in less than a third of a minute of computing."""
    monkeypatch.setattr(fitting, "SIZE", FULL_FIT // 3)
    began = time.process_time()
    done = export(table, motor, design, tmp_path / "out", fit=True)
    assert time.process_time() - began < 20.0
    entry = KsTable.load(done.folder / "ks_table.json").provenance["two_threshold"]
    costs = entry["performance"]
    assert set(costs) == {"table", "ramp", "hysteresis"}
    for cost in costs.values():
        assert 0.0 <= cost["lost_rate"] < 0.3
        assert 0.0 < cost["torque_ripple"] < cost["torque_dev"] < 0.5
    said = (done.folder / "README.md").read_text()
    assert f"{entry['ramp']['k_s_1_below_r_min']:g} r/min" in said
    assert f"{100 * costs['hysteresis']['torque_dev']:.2f} %" in said


def test_without_a_fit_the_folder_says_so(exported: Exported) -> None:
    assert "two_threshold" not in KsTable.load(exported.folder / "ks_table.json").provenance
    assert "Not fitted in this export" in (exported.folder / "README.md").read_text()
