"""The plant against trajectories of an independent simulator; see tests/data/golden/README.md."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sensorless.machine.magnetics import Floats
from sensorless.plant.case import read_case
from sensorless.plant.inputs import read_inputs
from sensorless.plant.run import COLUMNS, integrate, simulate_plant

GOLDEN = Path(__file__).parents[2] / "data" / "golden"
CASES = ("linear_fixed_speed", "linear_injection", "saturated_injection")
THINNED = 5
COMPARED = ("i_d", "i_q", "psi_d", "psi_q", "tau_M", "w_M")


def reference(name: str) -> Floats:
    return np.loadtxt(GOLDEN / f"{name}.csv", delimiter=",", skiprows=1)


def angle_between(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.abs(np.angle(np.exp(1j * (a - b)))))


@pytest.mark.parametrize("name", CASES)
def test_default_sub_steps_follow_the_reference(name: str) -> None:
    """Currents agree within 1e-6 A and angles within 1e-6 rad with the step of the closed loop."""
    want = reference(name)
    got = integrate(read_case(GOLDEN / f"{name}.json"), read_inputs(GOLDEN / f"{name}.u.csv"))
    got = got[::THINNED]
    assert len(got) == len(want)
    for column, field in enumerate(COMPARED):
        assert np.max(np.abs(got[:, column] - want[:, COLUMNS.index(field)])) < 1e-6, field
    assert np.max(angle_between(got[:, 6], want[:, COLUMNS.index("theta_m")])) < 1e-6


@pytest.mark.parametrize("name", CASES)
def test_simulated_file_has_the_format_of_the_reference(name: str, tmp_path: Path) -> None:
    """Same header, same instants to the letter, every number within 1e-8."""
    out = tmp_path / "out.csv"
    run = simulate_plant(GOLDEN / f"{name}.json", GOLDEN / f"{name}.u.csv", out)
    want = (GOLDEN / f"{name}.csv").read_text().splitlines()
    got = out.read_text().splitlines()
    assert got[0] == want[0] == ",".join(COLUMNS)
    got_rows = got[1::THINNED]
    assert [row.split(",")[0] for row in got_rows] == [row.split(",")[0] for row in want[1:]]
    a, b = (
        np.array([row.split(",") for row in rows], dtype=float) for rows in (got_rows, want[1:])
    )
    a[:, -1] = b[:, -1] + angle_between(a[:, -1], b[:, -1])
    assert np.max(np.abs(a - b)) < 1e-8
    assert run.step_error < 1e-8
    number = re.compile(r"-?\d+(\.\d+)?(e-\d\d)?")
    assert all(number.fullmatch(text) for text in ",".join(got[1:]).split(","))


def test_linear_reference_rejects_another_machine() -> None:
    """One per mille of q inductance is far outside the tolerance, so the comparison can fail."""
    case = read_case(GOLDEN / "linear_injection.json")
    other = replace(case, saturation=replace(case.saturation, a_q0=1.001 * case.saturation.a_q0))
    got = integrate(other, read_inputs(GOLDEN / "linear_injection.u.csv"))[::THINNED]
    assert np.max(np.abs(got[:, 1] - reference("linear_injection")[:, 2])) > 1e-4
