"""The table of a correction in a motor file: written, read, and refused where it is wrong."""

import dataclasses
import json
from pathlib import Path
from typing import Any

import pytest

from sensorless.design.carried import carried, record
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.machine.flux_correction import MOST, correction_table, read_correction
from sensorless.machine.mapped import tables_of
from sensorless.machine.motor import Motor
from sensorless.machine.motor_file import written
from sensorless.machine.sane import require_sane
from sensorless.suitability.finding import NOTE
from sensorless.suitability.plausible import plausible
from tests.helpers.machines import measured_machine, rough_machine

GOOD: dict[str, Any] = {
    "psi_d_from": -0.1,
    "psi_d_to": 1.0,
    "psi_q_to": 1.2,
    "energy": [[0.1 * (j + k) for k in range(5)] for j in range(6)],
}


def test_a_motor_file_gives_the_machine_back(tmp_path: Path) -> None:
    made = measured_machine()
    text = written(tables_of(made, "model", "pmsyrm_5600w", "beyond"), "head")
    (tmp_path / "made.toml").write_text(text, encoding="utf-8")
    read = Motor.load(tmp_path / "made.toml")
    assert read == made and read.digest == made.digest
    assert 'flux_correction = "beyond"' in text and len(text) < 8000


def test_a_run_carries_it() -> None:
    made = measured_machine()
    kept = json.loads(json.dumps(record(DriveDesign(), made)))
    assert carried(kept, "run").motor == made


def test_files_of_other_machines_do_not_name_it() -> None:
    motor = Motor.load("paper")
    assert "flux_correction" not in record(DriveDesign(), motor)["machine"]
    assert read_correction(None, "x") is None


def test_the_check_says_so() -> None:
    notes = [f for f in plausible(measured_machine()) if f.field == "flux_correction"]
    assert [f.weight for f in notes] == [NOTE] and "% of rated current" in notes[0].text
    assert not [f for f in plausible(Motor.load("paper")) if f.field == "flux_correction"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"psi_d_from": None}, "psi_d_from: missing"),
        ({"psi_d_to": -0.1}, "psi_d_to: -0.1 Vs: must be above psi_d_from = -0.1"),
        ({"psi_d_to": float("nan")}, "psi_d_to: nan: must be a finite number"),
        ({"psi_d_from": 0.0, "psi_d_to": 1e-320}, "psi_d_to: .* by at least 1e-09 Vs"),
        ({"psi_q_to": 0.0}, "psi_q_to: 0.0: must be between 1e-09 and"),
        ({"psi_q_to": 5e-324}, "psi_q_to: 5e-324: must be between 1e-09 and"),
        ({"psi_q_to": "wide"}, "psi_q_to: 'wide'"),
        ({"other": 1.0}, "other: unknown"),
        ({"energy": None}, "energy: missing; give 4 to 26 rows of 4 to 20 numbers"),
        ({"energy": 3.0}, "energy: 3.0; give 4 to 26 rows"),
        ({"energy": [[0.0] * 4] * 3}, "energy: 3 rows; give 4 to 26 rows"),
        ({"energy": [[0.0] * 4] * 27}, "energy: 27 rows"),
        ({"energy": [[0.0] * 21] * 4}, "energy: row 1: 21 numbers"),
        ({"energy": [[0.0] * 4] * 3 + [[0.0] * 5]}, "energy: row 4: 5 numbers; .* all alike"),
        ({"energy": [[0.0] * 4] * 3 + ["0000"]}, "energy: row 4: '0000'"),
        ({"energy": [[0.0] * 4] * 3 + [[0.0] * 3 + [float("nan")]]}, "energy: row 4: nan; give"),
        ({"energy": [[0.0] * 4] * 3 + [[0.0] * 3 + [True]]}, "energy: row 4: True; give"),
        ({"energy": [[0.0] * 4] * 3 + [[0.0] * 3 + [-1e7]]}, "energy: row 4: -10000000.0; give"),
        ({"energy": [[0.0] * 4] * 3 + [[0.0] * 3 + [10**400]]}, "energy: row 4: 1000.*; give"),
    ],
)
def test_a_wrong_table_is_refused(change: dict[str, Any], message: str) -> None:
    table = {k: v for k, v in (GOOD | change).items() if v is not None}
    with pytest.raises(UserError, match=f"mine: {message}") as error:
        read_correction(table, "mine")
    assert "\n" not in str(error.value)


def test_a_table_at_its_limits_is_read() -> None:
    most = GOOD | {"energy": [[0.0] * MOST[1]] * MOST[0]}
    assert read_correction(most, "x") is not None
    found = read_correction(GOOD, "x")
    assert found is not None
    assert read_correction(correction_table(found), "x") == found


def test_no_table_at_all_is_refused() -> None:
    with pytest.raises(UserError, match=r"x: must be a table, got \[\]"):
        read_correction([], "x")


def test_a_machine_that_folds_is_refused() -> None:
    """Where its own numbers are changed by hand until current falls with flux."""
    made = rough_machine()
    require_sane(made)
    f = made.flux_correction
    assert f is not None
    energy = tuple(tuple(300.0 * x for x in row) for row in f.energy)
    wild = dataclasses.replace(made, flux_correction=dataclasses.replace(f, energy=energy))
    with pytest.raises(UserError, match=r"'paper': flux_correction: current does not rise .* A"):
        require_sane(wild)
