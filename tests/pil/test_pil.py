"""The exported core on the emulated Cortex-M4F: the same words, within the budgets."""

import json
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.pil import pil as loop
from sensorless.pil.pil import Report, passed, pil
from sensorless.pil.report import table as report_table
from sensorless.pil.report import write_report
from sensorless.pil.scenarios import PLANS
from sensorless.table.ks_table import Axis, KsTable
from tests.helpers.scenarios import on_the_target


def test_no_word_differs(report: Report) -> None:
    assert report["mismatches"] == 0, report["first_mismatch"]
    assert report["lookup_mismatches"] == 0
    assert report["periods"] > 100_000
    assert passed(report)


def test_the_scenarios_are_what_they_say(report: Report) -> None:
    """Hand-over both ways: the weight reaches both ends; one drive, and only that, gets lost."""
    found = {s["name"]: s for s in report["scenarios"]}
    assert found["hand-over both ways"]["k_s"] == [0.0, 1.0]
    assert found["broken sensor"]["lost"] is not None
    assert [name for name in PLANS if found[name]["lost"]] == ["broken sensor"]


def test_every_test_on_the_target_passes(report: Report) -> None:
    assert len(report["target_tests"]) == 10
    assert not any(report["target_tests"].values()), report["target_tests"]


def test_instruction_budgets(report: Report) -> None:
    """Two axes: any lookup within 65, any period with its decision within 1570.

    That is 170 beyond 1400: the check of every word, what lasts of an EMF, and the torque in field
    weakening (docs/integrate-the-table.md).
    """
    count = report["instructions"]
    assert 30 < count["lookup_f32"]["min"] and count["lookup_f32"]["max"] <= 65
    assert count["lookup_q15"]["max"] <= 80, "four nodes more to convert"
    assert 500 < count["drive_step"]["min"] and count["period"]["max"] <= 1570


def test_memory_budgets(report: Report) -> None:
    assert report["flash_table_and_check"] <= 4096
    assert round(report["flash_core"] / 1000) == 32, "the README says 32 kB"
    assert report["ram_state"] <= 1024
    assert report["stack"] <= 1024
    for name in ("drive.o", "ks_schedule.o", "ks_table.o"):
        assert report["memory"][name].get("data", 0) + report["memory"][name].get("bss", 0) == 0


def test_no_fused_multiply_add(report: Report) -> None:
    assert report["fused_instructions"] == 0


def test_it_is_done_in_time(report: Report) -> None:
    assert report["seconds"] < 120.0


def test_the_report_can_be_read(report: Report, tmp_path: Path) -> None:
    write_report(report, tmp_path / "pil.json")
    assert json.loads((tmp_path / "pil.json").read_text())["periods"] == report["periods"]
    console = Console(record=True, width=120)
    console.print(report_table(report))
    assert "control periods compared" in console.export_text()


@pytest.mark.usefixtures("target", "without_selftest")
def test_three_axes_stay_within_the_budgets(motor: Motor, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(loop, "pil_scenarios", on_the_target(0.15))
    axes = (
        Axis("speed", 0.0, 0.5, 5),
        Axis("torque_current", -1.5, 1.5, 4),
        Axis("disagreement", -1.0, 1.0, 3),
    )
    nodes = np.random.default_rng(3).random((5, 4, 3)).astype(np.float32)
    for level in ("-Os", "-O2"):
        found = pil(KsTable(axes, nodes), motor, DriveDesign(), size=9, level=level)
        assert passed(found)
        assert found["instructions"]["lookup_f32"]["max"] <= 130
    # As exported, -O2.
    assert found["instructions"]["period"]["max"] <= 1570


def test_without_the_tools_one_line_names_the_packages(
    table: KsTable, motor: Motor, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(UserError, match="gcc-arm-none-eabi qemu-system-arm") as error:
        pil(table, motor, DriveDesign())
    assert "\n" not in str(error.value)
