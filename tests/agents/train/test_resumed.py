"""What a resumed run tells of itself: when it went on, by what command, from which start."""

import csv
import json
import shutil
import zipfile
from io import BytesIO
from pathlib import Path

import pytest
import torch

from sensorless.agents.loading import TABLE
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.curve import PROGRESS
from sensorless.agents.train.run_folder import LATEST, START
from sensorless.agents.train.train import resume, train
from sensorless.baselines.linear import linear_table
from sensorless.design.carried import commands_of
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies.registry import table_named
from sensorless.table.ks_table import KsTable
from tests.helpers.scenarios import briefly

SMALL = TrainConfig(
    n_envs=16, n_steps=16, n_epochs=1, steps=512, warm_up=0, validate_size=16, eval_freq=256
)

pytestmark = pytest.mark.usefixtures("brief")


@pytest.fixture(scope="module")
def twice(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of a short run that went on once, its best table being the last."""
    folder = tmp_path_factory.mktemp("runs") / "twice"
    last = TrainConfig(**{**SMALL.__dict__, "last": True})
    with briefly():
        train(last, DriveDesign(), folder, table_named("eq25", Motor.load("paper")))
        resume({"steps": 512}, folder)
    return folder


def test_the_curve_has_one_row_for_a_number_of_decisions(twice: Path) -> None:
    with (twice / PROGRESS).open() as file:
        steps = [int(row["steps"]) for row in csv.DictReader(file)]
    assert steps == [0, 256, 512, 768, 1024]


def test_configuration_and_schedule_say_that_the_run_went_on(twice: Path) -> None:
    (more,) = json.loads((twice / "config.json").read_text())["resumed"]
    assert more["steps"] == 512 and more["versions"]["torch"]
    known = KsTable.load(twice / TABLE).provenance
    assert known["resumed"] == [more]
    assert commands_of(known) == [known["command"], more["command"]]


@pytest.mark.parametrize(
    ("member", "place", "value"),
    [
        ("policy.pth", "value_net.0.bias", float("nan")),
        ("policy.pth", "actor.values", float("inf")),
        ("policy.optimizer.pth", "exp_avg", float("nan")),
        ("policy.optimizer.pth", "exp_avg_sq", -1.0),
    ],
)
def test_a_checkpoint_whose_numbers_are_damaged_is_refused(
    member: str, place: str, value: float, twice: Path, tmp_path: Path
) -> None:
    run = shutil.copytree(twice, tmp_path / "run")
    with zipfile.ZipFile(run / LATEST) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    saved = torch.load(BytesIO(parts[member]))
    states = [saved] if member == "policy.pth" else list(saved["state"].values())
    name = next(key for key in states[0] if place in key or key.endswith(place.split(".")[-1]))
    states[-1][name].view(-1)[0] = value
    out = BytesIO()
    torch.save(saved, out)
    with zipfile.ZipFile(run / LATEST, "w") as archive:
        for name, content in {**parts, member: out.getvalue()}.items():
            archive.writestr(name, content)
    with pytest.raises(UserError, match=r"latest\.zip: a weight or a moment .*restore this run's"):
        resume({"steps": 512}, run)


def test_a_setting_out_of_range_names_its_file(twice: Path, tmp_path: Path) -> None:
    run = shutil.copytree(twice, tmp_path / "run")
    config = json.loads((run / "config.json").read_text())
    config["train"]["batch_size"] = -1
    (run / "config.json").write_text(json.dumps(config))
    with pytest.raises(UserError, match=r"config\.json: train: batch_size: -1: .*restore the file"):
        resume({"steps": 512}, run)


def test_another_start_is_refused(twice: Path, tmp_path: Path) -> None:
    """What was learned would be compared with a start that it never had."""
    run = shutil.copytree(twice, tmp_path / "run")
    start = KsTable.load(run / START)
    linear_table(0.6, 0.9).save(run / START, start.provenance)
    with pytest.raises(UserError, match=r"start\.json: not the start of this run, digest .*anew"):
        resume({"steps": 512}, run)
