"""One schedule for all machines: the table of a point, its cost, and a small search."""

import sys
from pathlib import Path

import numpy as np
import pytest

from sensorless.table.ks_table import KsTable
from tests.helpers.script import script

STUDY = script("studies/one_schedule.py")


def test_the_middle_is_static_but_for_three_quarters_of_the_injected_voltage() -> None:
    table = STUDY.table_of(np.full(2 + 4 * 3, 0.5))
    values = {g.gain: float(g.values[0]) for g in table.gains}
    assert values == {"observer": 0.0, "injection": 0.0, "l_q": 0.0, "amplitude": -0.5}
    amplitude = table.gains[3]
    assert (amplitude.low, amplitude.high) == (0.5, 1.0)  # -1 is half, 0 all of the voltage
    speed = table.axes[0].nodes
    assert table.values == pytest.approx(np.clip((0.26 - speed) / 0.185, 0.0, 1.0), abs=1e-6)


def test_cost_rises_with_what_exceeds_the_own_ramp_and_with_losses() -> None:
    level = np.array([[0.0, 1.0, 1.0], [0.0, 1.0, 1.0]])
    better, worse, lost = level.copy(), level.copy(), level.copy()
    better[0, 1], worse[0, 1], lost[0, 0] = 0.95, 1.05, 1.0
    values = [STUDY.cost(found, 16) for found in (better, level, worse, lost)]
    assert values == sorted(values) and len(set(values)) == 4
    assert values[3] - values[1] == pytest.approx(STUDY.LOSS / 32)
    assert values[2] - values[1] > 4.0 * (values[1] - values[0])


def test_search_writes_a_table_of_no_machine(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(STUDY, "own_ramp", lambda *_: "linear:60,240")
    out = tmp_path / "one.json"
    words = "--machines 2 --generations 6 --size 4 --seed 3 --out".split()
    monkeypatch.setattr(sys, "argv", [STUDY.__name__, *words, str(out)])
    STUDY.main()
    table = KsTable.load(out)
    assert [g.gain for g in table.gains] == ["observer", "injection", "l_q", "amplitude"]
    assert table.provenance["machines"]["n"] == 2 and "motor_digest" not in table.provenance
