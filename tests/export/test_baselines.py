"""Any rule that is a table gives the same folder; the others are refused in one line."""

import importlib.util
from pathlib import Path

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.export.export import export, table_of
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.table.ks_table import KsTable

FUZZY = pytest.mark.skipif(importlib.util.find_spec("simpful") is None, reason="needs simpful")


@pytest.mark.parametrize(
    "spec",
    [
        "eq25",
        "linear:200,500",
        "smoothstep",
        pytest.param("fuzzy", marks=FUZZY),
        "constant:0.5",
        "hfi",
        "smo",
    ],
)
def test_a_rule_with_a_table_is_exported(
    spec: str, tmp_path: Path, motor: Motor, design: DriveDesign, request: pytest.FixtureRequest
) -> None:
    """The self test runs for one rule of one axis and for the one of two."""
    if spec not in ("eq25", "fuzzy"):
        request.getfixturevalue("without_selftest")
    policy = make_policy(spec, motor)
    table = table_of(policy, spec)
    done = export(table, motor, design, tmp_path / "out", policy=policy.name)
    read = KsTable.load(done.folder / "ks_table.json")
    assert read.digest == table.digest and read.provenance["policy"] == policy.name
    assert "passed" in done.self_test.message or not done.self_test.ran


@pytest.mark.parametrize("spec", ["hysteresis", "ramp", "gated", "sensored", "oracle"])
def test_a_rule_without_a_table_is_refused(spec: str, motor: Motor) -> None:
    with pytest.raises(UserError, match=f"^run: '{spec}' is not a table .*; export a training run"):
        table_of(make_policy(spec, motor), spec)
