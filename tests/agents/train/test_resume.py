"""A run goes on where it stopped: counter, learning curve, best table, and no pickle."""

import csv
import errno
import json
import os
import pickle
import shutil
import sys
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from sensorless.agents.loading import TABLE
from sensorless.agents.train.alone import alone
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.curve import PROGRESS
from sensorless.agents.train.run_folder import LATEST, fresh
from sensorless.agents.train.train import TablePPO, resume, train
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies.registry import table_named
from sensorless.table.ks_table import KsTable
from tests.helpers.command import run as command
from tests.helpers.scenarios import briefly

pytestmark = pytest.mark.usefixtures("brief")


START = table_named("eq25", Motor.load("paper"))

SMALL = TrainConfig(n_envs=16, n_steps=16, n_epochs=1, steps=512, warm_up=1, validate_size=16)
ON = {"steps": SMALL.steps}


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a short run."""
    folder = tmp_path_factory.mktemp("runs") / "first"
    with briefly():
        train(SMALL, DriveDesign(), folder, START)
    return folder


def rows(folder: Path) -> list[dict[str, str]]:
    with (folder / PROGRESS).open() as file:
        return list(csv.DictReader(file))


def rewrite(path: Path, member: str, data: bytes) -> None:
    """Replace one member of an archive."""
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in {**parts, member: data}.items():
            archive.writestr(name, content)


def test_curve_goes_on_and_the_best_table_stays(finished: Path) -> None:
    lines = (finished / PROGRESS).read_text().splitlines()
    steps, _, *more = lines[-1].split(",")
    lines[-1] = ",".join((steps, "100.0", *more))
    (finished / PROGRESS).write_text("\n".join(lines) + "\n")
    before = rows(finished)
    text = (finished / TABLE).read_text()
    document: dict[str, Any] = json.loads(text)
    unbeatable = {"lost_rate": 0.0, "torque_dev": 0.0, "torque_ripple": 0.0}
    table = KsTable.load(finished / TABLE)
    table.save(finished / TABLE, {**document["provenance"], "validation": unbeatable})
    kept = (finished / TABLE).read_text()
    resume(ON, finished)
    after = rows(finished)
    assert after[: len(before)] == before and len(after) > len(before)
    assert int(after[-1]["steps"]) >= int(before[-1]["steps"]) + SMALL.steps
    assert float(after[-1]["seconds"]) >= 100.0
    assert (finished / TABLE).read_text() == kept


def test_resume_refuses_other_settings(finished: Path) -> None:
    before = rows(finished)
    with pytest.raises(UserError, match=r"hfi_pll_hz=40 was asked.*14.934: .*train anew"):
        resume(ON, finished, asked={"hfi_pll_hz": 40.0})
    assert rows(finished) == before


@pytest.mark.parametrize(("name", "value"), [("lr_nodes", 0.5), ("seed", 9), ("n_envs", 256)])
def test_resume_refuses_other_options(name: str, value: float, finished: Path) -> None:
    """Also one at the default of a new run, which is not that of this run."""
    before = rows(finished)
    option = f"--{name.replace('_', '-')}"
    asked = ("train", "--resume", str(finished), "--steps", "512", option, str(value))
    done = command(*asked, cwd=finished)
    said = f"{name}: {value}: {str(finished)!r} was started with {getattr(SMALL, name)}"
    assert done.returncode == 2 and said in done.stderr and option in done.stderr
    assert rows(finished) == before
    resume({**ON, name: getattr(SMALL, name)}, finished)
    assert len(rows(finished)) > len(before)


def test_a_resumed_run_warms_up_no_more(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Updates count from the start of the run; the one that a budget ends in is whole."""
    learns: list[bool] = []
    update = TablePPO.train

    def watched(self: TablePPO) -> None:
        learns.append(bool(self.policy.learn_actor))
        update(self)

    monkeypatch.setattr(TablePPO, "train", watched)
    config = replace(SMALL, warm_up=3, n_epochs=2, steps=600)
    train(config, DriveDesign(), tmp_path / "run", START)
    assert learns == [False] * 3
    resume({"steps": 600}, tmp_path / "run")
    assert learns == [False] * 3 + [True] * 3


def test_resume_unpickles_nothing(finished: Path) -> None:
    with zipfile.ZipFile(finished / LATEST) as archive:
        known = json.loads(archive.read("data"))
    counters = {name: known[name] for name in ("num_timesteps", "_n_updates")}
    steps = counters["num_timesteps"]
    rewrite(finished / LATEST, "data", json.dumps(counters).encode())
    resume(ON, finished)
    assert int(rows(finished)[-1]["steps"]) >= steps + SMALL.steps


@pytest.mark.parametrize(
    "weights", [pickle.dumps({"weights": Path("somewhere")}, protocol=2), bytes(range(256))]
)
def test_a_checkpoint_that_cannot_be_unpickled_is_refused_in_one_line(
    weights: bytes, tmp_path: Path, finished: Path
) -> None:
    run = tmp_path / "run"
    shutil.copytree(finished, run)
    rewrite(run / LATEST, "policy.pth", weights)
    with pytest.raises(UserError, match="restore this run's checkpoint") as caught:
        resume(ON, run)
    assert "weights_only" not in str(caught.value)
    assert "\n" not in str(caught.value)


def test_the_curve_is_cut_back_to_the_checkpoint(tmp_path: Path, finished: Path) -> None:
    """A run was killed after it wrote its curve, and before it wrote its checkpoint."""
    run = tmp_path / "run"
    shutil.copytree(finished, run)
    before = rows(run)
    with (run / PROGRESS).open("a") as file:
        file.write("999999999,1e6,0,0,0,0,1\n")
    (run / "checkpoints" / f".latest.zip.{2**22 + 1}.part").touch()
    os.utime(run / "checkpoints" / f".latest.zip.{2**22 + 1}.part", (0.0, 0.0))
    resume(ON, run)
    after = rows(run)
    assert after[: len(before)] == before and int(after[-1]["steps"]) < 999999999
    assert [path.name for path in (run / "checkpoints").iterdir()] == ["latest.zip"]


def test_a_run_killed_before_its_first_checkpoint_begins_anew(
    tmp_path: Path, finished: Path
) -> None:
    run = tmp_path / "run"
    shutil.copytree(finished, run)
    (run / LATEST).unlink()
    with pytest.raises(UserError, match=r"no checkpoints/latest\.zip"):
        resume(ON, run)
    for name in (TABLE, PROGRESS):
        (run / name).unlink()
    with fresh(shutil.copytree(run, tmp_path / "again")):
        assert not list((tmp_path / "again").iterdir()), "train --name starts over"
    resume(ON, run)
    assert int(rows(run)[0]["steps"]) == 0 and (run / LATEST).is_file()


@pytest.mark.parametrize(
    "files",
    [
        ("tb/PPO_1/events.out.tfevents.1", "checkpoints/rl_model_1000_steps.zip"),
        ("checkpoints/rl_model_1000_steps.zip",),
        ("tb/events.out.tfevents.1",),
        ("config.json",),
    ],
)
def test_files_that_are_not_of_a_run_are_kept(files: tuple[str, ...], tmp_path: Path) -> None:
    """Another program's folder may have names that a run uses, too."""
    for name in files:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("mine")
    with pytest.raises(UserError, match="already exists"), fresh(tmp_path):
        pass
    assert all((tmp_path / name).read_text() == "mine" for name in files)


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda text: text.replace(",objective", ""), "line 1: 'steps,seconds,.*not the columns"),
        (lambda text: text.replace("objective", "objektive"), "line 1: .*not the columns"),
        (lambda text: text[: text.rindex(",")], "line [0-9]+: 6 values, not 7"),
        (lambda text: text.replace("\n0,", "\n0.5,"), "line 2: steps: '0.5' is no finite number"),
        (lambda text: text.replace("\n0,", "\n0,x"), "line 2: seconds: 'x.* is no finite number"),
        (lambda text: text.replace("\n0,", "\n0,1e999"), "line 2: seconds: '1e999.* finite number"),
    ],
)
def test_a_damaged_curve_is_refused_in_one_line(
    damage: Callable[[str], str], said: str, tmp_path: Path, finished: Path
) -> None:
    run = shutil.copytree(finished, tmp_path / "run")
    (run / PROGRESS).write_text(damage((run / PROGRESS).read_text()))
    with pytest.raises(UserError, match=rf"progress\.csv: {said}.*restore the file") as caught:
        resume(ON, run)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("name", "said"), [("gamma", "train: gamma: missing"), ("foo", "train: foo: unknown")]
)
def test_settings_of_another_version_are_named(
    name: str, said: str, tmp_path: Path, finished: Path
) -> None:
    """A default of today would change a run unnoticed."""
    run = shutil.copytree(finished, tmp_path / "run")
    config = json.loads((run / "config.json").read_text())
    if config["train"].pop(name, None) is None:
        config["train"][name] = 1
    (run / "config.json").write_text(json.dumps(config))
    with pytest.raises(UserError, match=rf"config\.json: {said}; restore the file"):
        resume(ON, run)


@pytest.mark.parametrize("validation", [None, {"lost_rate": "x"}, {"more": 1}])
def test_a_schedule_without_its_validation_is_refused(
    validation: dict[str, object] | None, tmp_path: Path, finished: Path
) -> None:
    """Nothing would tell whether what is learned next is better."""
    run = shutil.copytree(finished, tmp_path / "run")
    table = KsTable.load(run / TABLE)
    found = {**table.provenance["validation"], **validation} if validation else "none"
    table.save(run / TABLE, {**table.provenance, "validation": found})
    with pytest.raises(UserError, match=r"run: validation of the schedule: .*; restore the file"):
        resume(ON, run)


def test_a_damaged_checkpoint_is_refused_in_one_line(finished: Path) -> None:
    (finished / LATEST).write_bytes(b"not a checkpoint")
    with pytest.raises(UserError, match="restore this run's checkpoint") as caught:
        resume(ON, finished)
    assert "\n" not in str(caught.value)


@pytest.mark.skipif(sys.platform == "win32", reason="no locks there")
def test_a_run_that_is_being_trained_is_refused(tmp_path: Path, finished: Path) -> None:
    new, run = tmp_path / "new", shutil.copytree(finished, tmp_path / "run")
    before = rows(run)
    with fresh(new), alone(run):
        with pytest.raises(UserError, match="in use by another training"):
            train(SMALL, DriveDesign(), new, START)
        with pytest.raises(UserError, match="in use by another training"):
            resume(ON, run)
        assert not list(new.iterdir()) and rows(run) == before
    with alone(run):
        pass


def test_a_name_that_is_not_utf8_is_refused(tmp_path: Path, finished: Path) -> None:
    new, run = (tmp_path / os.fsdecode(name) for name in (b"n\xff", b"r\xff"))
    with pytest.raises(UserError, match=r"name: .* is not UTF-8"):
        train(SMALL, DriveDesign(), new, START)
    assert not new.exists()
    shutil.copytree(finished, run)
    with pytest.raises(UserError, match=r"resume: .* is not UTF-8"):
        resume(ON, run)


def test_a_run_that_cannot_be_written_to_is_refused(
    finished: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def read_only(path: Path) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS), str(path))

    monkeypatch.setattr(Path, "touch", read_only)
    with pytest.raises(UserError, match=f"output folder '{finished}': Read-only file system"):
        resume(ON, finished)


def test_a_name_with_spaces_is_quoted_in_the_way_on(tmp_path: Path, finished: Path) -> None:
    run = shutil.copytree(finished, tmp_path / "a b")
    with pytest.raises(UserError, match=f"--resume '{run}'"):
        train(SMALL, DriveDesign(), run, START)
