"""Tables of the pages are those of the records in ``results/studies``."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

ROOT = Path(__file__).parents[2]


def record(name: str) -> Any:
    return json.loads((ROOT / "results" / "studies" / f"{name}.json").read_text(encoding="utf-8"))


def text(page: str) -> str:
    return (ROOT / "docs" / page).read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("name", "place"), [("identify", 0), ("identify-held-out", 1), ("identify-details", 2)]
)
def test_errors_of_an_identification(name: str, place: int) -> None:
    told = record(name)["summary"]
    page = text("identify.md")
    for what in ("R_s", "psi_f", "L_d", "L_q", "J"):
        row = re.findall(rf"^\| {what}, at most \d+ % \|(.*)\|$", page, re.MULTILINE)[place]
        found = told[what]
        assert [cell.strip() for cell in row.split("|")] == [
            f"{found['within']} of {told['identified']}",
            f"{100 * found['median']:.2f} %",
            f"{100 * found['95 %']:.2f} %",
            f"{100 * found['worst']:.1f} %",
        ], what


def test_faults_of_sensors() -> None:
    campaign = record("fault_campaign")
    faults = [f for e in campaign.values() if "faults" in e for f in e["faults"].values()]
    total = {name: sum(f[name] for f in faults) for name in ("cases", "lost", "tripped")}
    page = " ".join(text("integrate-the-table.md").split())
    assert f"{total['cases']} cases over five estimators" in page
    assert f"Of {total['lost']} lost drives {sum(f['lost_unseen'] for f in faults)} had" in page
    assert f"of {total['tripped']} trips {sum(f['tripped_unseen'] for f in faults)} came" in page
    assert f"largest current was {max(f['peak_A'] for f in faults):.1f} A" in page


def test_gains_on_many_machines() -> None:
    machines = list(record("any_machine")["machines"].values())
    lost = {s: [m[s]["lost_rate"] for m in machines] for s in ("nominal", "stress-1")}
    means = [
        100 * np.exp(np.mean(np.log([m["nominal"][name] for m in machines])))
        for name in ("torque_dev_rms", "torque_ripple_rms")
    ]
    (row,) = re.findall(r"^\| \*\*from the machine\*\* \|(.*)\|$", text("gains.md"), re.MULTILINE)
    assert [cell.strip(" *") for cell in row.split("|")] == [
        f"{100 * np.mean(lost['nominal']):.2f} %",
        f"{sum(x <= 0.01 for x in lost['nominal'])} of {len(machines)}",
        f"{means[0]:.2f} / {means[1]:.2f} %",
        f"{100 * np.mean(lost['stress-1']):.1f} % ({100 * np.median(lost['stress-1']):.0f})",
    ]


def near(told: str, value: float) -> bool:
    decimals = len(told.partition(".")[2])
    return abs(float(told) - value) <= 0.51 * 10.0**-decimals


def test_rated_torque_at_standstill() -> None:
    motors = record("standstill")["motors"]
    part = text("control.md").split("## Rated torque at standstill")[1]
    name, rows = "", re.findall(r"^\| (?:`(\w+)`, )?`(\w+)` \|(.*)\|$", part, re.MULTILINE)
    assert len(rows) == 2 * len(motors)
    for motor, estimator, cells in rows:
        name = motor or name
        found = motors[name][estimator]
        wanted = [
            found[j][x] for j in ("J x 1", "J x 0.5") for x in ("torque_pct", "torque_worst_pct")
        ]
        told = re.findall(r"[\d.]+", cells)
        assert all(map(near, told, [*wanted, found["dip_rpm"], found["twin_dip_rpm"]]))
        assert ("limit cycle" in cells) == any(
            found[j]["limit_cycle"] for j in ("J x 1", "J x 0.5")
        )
