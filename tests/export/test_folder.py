"""Where an export goes, what it says about its origin, and what it refuses."""

import os
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.export.export import Exported, export
from sensorless.export.provenance import settings_digest
from sensorless.machine.motor import Motor
from sensorless.table.ks_table import KsTable


def test_the_json_is_the_table_and_its_origin(
    exported: Exported, table: KsTable, motor: Motor
) -> None:
    t = KsTable.load(exported.folder / "ks_table.json")
    assert t.digest == table.digest and t.values.tobytes() == table.values.tobytes()
    assert t.provenance["command"] == "train --seed 5"
    assert t.provenance["policy"] == "trial"
    assert t.provenance["motor_digest"] == motor.digest
    code = (exported.folder / "ks_table_data.c").read_text()
    assert t.provenance["export"]["crc"]["f32_header"][2:].upper() in code
    last = {"ks_table.json", "SHA256SUMS"}
    assert set(t.provenance["export"]["sha256"]) == set(exported.files) - last
    assert set(exported.files) == {
        p.relative_to(exported.folder).as_posix() for p in exported.folder.rglob("*") if p.is_file()
    }


@pytest.mark.skipif(shutil.which("sha256sum") is None, reason="needs sha256sum")
def test_every_file_has_a_checksum(exported: Exported, copied: Path) -> None:
    check = ["sha256sum", "--strict", "--quiet", "-c", "SHA256SUMS"]
    subprocess.run(check, cwd=copied, check=True)
    listed = {line.split("  ")[1] for line in (copied / "SHA256SUMS").read_text().splitlines()}
    assert listed == set(exported.files) - {"SHA256SUMS"}
    with (copied / "params.c").open("a") as file:
        file.write(" ")
    done = subprocess.run(check, cwd=copied, capture_output=True, text=True, check=False)
    assert done.returncode == 1 and done.stdout == "params.c: FAILED\n"


def test_licence_and_origin_go_along(
    exported: Exported, motor: Motor, design: DriveDesign, table: KsTable
) -> None:
    root = Path(__file__).parents[2]
    assert (exported.folder / "LICENSE").read_bytes() == (root / "LICENSE").read_bytes()
    said = (exported.folder / "PROVENANCE.txt").read_text(encoding="utf-8")
    for word in ("train --seed 5", motor.digest, settings_digest(design), table.digest, "trial"):
        assert word in said
    assert settings_digest(design) != settings_digest(replace(design, estimator="smo"))


@pytest.mark.usefixtures("without_selftest")
@pytest.mark.parametrize(
    ("estimator", "observer"), [("smo", "sliding-mode observer"), ("flux", "flux observer")]
)
def test_the_readme_names_the_observer_that_leads(
    estimator: str, observer: str, tmp_path: Path, table: KsTable, motor: Motor, design: DriveDesign
) -> None:
    done = export(table, motor, replace(design, estimator=estimator), tmp_path / "out")
    said = (done.folder / "README.md").read_text(encoding="utf-8")
    assert f"0: the {observer} leads" in said
    other = {"sliding-mode", "flux observer"} - {observer, observer.split()[0]}
    assert not any(name in said for name in other)


@pytest.mark.usefixtures("without_selftest")
def test_the_readme_of_a_coupled_drive_knows_one_estimate(
    tmp_path: Path, table: KsTable, motor: Motor, design: DriveDesign
) -> None:
    done = export(table, motor, replace(design, estimator="coupled"), tmp_path / "out")
    said = (done.folder / "README.md").read_text(encoding="utf-8")
    assert "one estimate of the rotor, that of the coupled observer" in said
    assert "two estimators" not in said


@pytest.mark.usefixtures("without_selftest")
@pytest.mark.usefixtures("whole_run")
def test_the_same_policy_gives_the_same_files(
    exported: Exported, tmp_path: Path, table: KsTable, motor: Motor, design: DriveDesign
) -> None:
    again = export(table, motor, design, tmp_path / "again", policy="trial")
    for name in exported.files:
        assert (again.folder / name).read_bytes() == (exported.folder / name).read_bytes(), name


@pytest.mark.usefixtures("without_selftest")
def test_a_policy_whose_name_is_not_utf8_is_exported(
    tmp_path: Path, table: KsTable, motor: Motor, design: DriveDesign
) -> None:
    done = export(table, motor, design, tmp_path / os.fsdecode(b"o\xff"), policy="b\udcff")
    assert "b\\udcff" in (done.folder / "README.md").read_text(encoding="utf-8")


@pytest.mark.usefixtures("without_selftest")
def test_an_earlier_export_is_replaced_and_nothing_else(
    exported: Exported, copied: Path, table: KsTable, motor: Motor, design: DriveDesign
) -> None:
    (copied / "build").mkdir()
    (copied / "build" / "selftest").write_text("old")
    constant = replace(table, values=np.ones((9, 5), dtype=np.float32))
    export(constant, motor, design, copied)
    assert KsTable.load(copied / "ks_table.json").digest == constant.digest
    assert not (copied / "build").exists()
    (copied / "notes.txt").write_text("mine")
    with pytest.raises(UserError, match=r"has 'notes.txt', which no export wrote"):
        export(table, motor, design, copied)
    assert KsTable.load(copied / "ks_table.json").digest == constant.digest
    assert [p.name for p in copied.parent.iterdir()] == ["copy"]


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda p: (p / "out").write_text("a file"), "out' is a file; give a folder"),
        (lambda p: (p / "out" / "sub").mkdir(parents=True), "has 'sub' and is no export"),
        (lambda p: (p / "out").symlink_to("/proc/self"), "and is no export"),
    ],
)
def test_anything_else_is_left_alone(
    tmp_path: Path,
    make: Callable[[Path], object],
    message: str,
    table: KsTable,
    motor: Motor,
    design: DriveDesign,
) -> None:
    make(tmp_path)
    with pytest.raises(UserError, match=message):
        export(table, motor, design, tmp_path / "out")
    assert [p.name for p in tmp_path.iterdir()] == ["out"]


def test_a_place_that_cannot_be_written_is_named(
    tmp_path: Path, table: KsTable, motor: Motor, design: DriveDesign
) -> None:
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file" / "out", Path("/proc/none/out")):
        with pytest.raises(
            UserError, match=r"output folder .*; give a folder that can be written to"
        ):
            export(table, motor, design, place)


def test_what_does_not_belong_together_is_refused(
    tmp_path: Path, table: KsTable, motor: Motor, design: DriveDesign
) -> None:
    other = replace(table, provenance={"motor_digest": "0" * 64})
    with pytest.raises(UserError, match=r"motor: 'paper', digest .*; give the machine"):
        export(other, motor, design, tmp_path / "out")
    with pytest.raises(UserError, match="k_s_slew: 50 1/s; the policy's table was made for 20 1/s"):
        export(replace(table, slew_per_s=20.0), motor, design, tmp_path / "out")
    assert not list(tmp_path.iterdir())
