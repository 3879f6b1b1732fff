"""Any rule that is a table gives the same folder; the others are refused in one line."""

import importlib.util
from dataclasses import replace
from pathlib import Path

import pytest

from sensorless.baselines.linear import eq25_band
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.export.code import c_float
from sensorless.export.export import export, table_of, with_rule
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


@pytest.mark.parametrize("name", ["brusa_hsm1", "paper"])
def test_a_damaged_table_leaves_the_machines_own_rule(name: str) -> None:
    """Eq. 25 of this machine, unless the table brings another."""
    motor = Motor.load(name)
    table = with_rule(table_of(make_policy("constant:0.5", motor), ""), motor)
    assert table.rule == pytest.approx(eq25_band(motor))
    own = replace(table, rule=(0.1, 0.5))
    assert with_rule(own, motor) is own


@pytest.mark.usefixtures("without_selftest")
def test_every_file_of_an_export_has_the_same_rule(tmp_path: Path, design: DriveDesign) -> None:
    motor = Motor.load("brusa_hsm1")
    table = table_of(make_policy("eq25", motor), "eq25")
    folder = export(table, motor, design, tmp_path / "out").folder
    high = KsTable.load(folder / "ks_table.json").rule[1]
    assert high == pytest.approx(0.36, abs=1e-3)
    assert f"{c_float(high)}" in (folder / "params.c").read_text().split(".rule = ")[1][:60]
    assert c_float(high) in (folder / "ks_hook_params.c").read_text()
    assert f"0 above {high:.3g}" in (folder / "README.md").read_text()


@pytest.mark.parametrize("spec", ["hysteresis", "ramp", "gated", "sensored", "oracle"])
def test_a_rule_without_a_table_is_refused(spec: str, motor: Motor) -> None:
    with pytest.raises(UserError, match=f"^run: '{spec}' is not a table .*; export a training run"):
        table_of(make_policy(spec, motor), spec)
