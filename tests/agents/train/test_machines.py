"""Training over random machines: repeatable, gone on with, and usable on any machine."""

import json
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.agents.loading import load_run, provenance
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.env import training_env
from sensorless.agents.train.judge import judge
from sensorless.agents.train.run_folder import design_and_motor
from sensorless.agents.train.train import resume, train
from sensorless.baselines.linear import linear_table
from sensorless.cli.app import app
from sensorless.design.drive import DriveDesign
from sensorless.envs.privileged import N_PRIVILEGED
from sensorless.envs.scenarios import machine_family
from sensorless.envs.scenarios.machine_family import family, family_digest
from sensorless.envs.scenarios.machines import JUDGED, Machines
from sensorless.envs.scenarios.machines_suite import judged
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.signals import N_SIGNALS
from sensorless.errors import UserError
from sensorless.evaluation.validation import validate, validate_all
from sensorless.export.export import export
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy, table_named
from sensorless.table.ks_table import KsTable
from tests.helpers.scenarios import briefly

pytestmark = pytest.mark.usefixtures("brief")


START = table_named("eq25", Motor.load("paper"))

SMALL = TrainConfig(
    machines=3, n_envs=16, n_steps=16, batch_size=128, n_epochs=1, steps=1024, warm_up=1,
    validate_size=16, eval_freq=512, average=2,
)  # fmt: skip
NAMES = ("paper", "ipmsm_2200w", "pmsyrm_5600w")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder: Path = tmp_path_factory.mktemp("runs") / "family"
    with briefly():
        train(SMALL, DriveDesign(), folder, START)
    return folder


def test_drives_are_shared_out_over_the_machines() -> None:
    env = training_env(SMALL, DriveDesign(), family(1, 3))
    assert env.num_envs == 16
    assert [part.num_envs for part in env.env.envs] == [6, 6, 4]  # type: ignore[union-attr]
    assert [part.batch.motor for part in env.env.envs] == [*family(1, 3)]  # type: ignore[union-attr]


def test_the_critic_sees_which_machine_it_judges() -> None:
    """Also in the last observation of an episode; the policy's own columns stay what they were."""
    env = training_env(SMALL, DriveDesign(), family(1, 3))
    env.seed(3)
    observation: Any = env.reset()
    which = np.repeat(np.eye(3), [6, 6, 4], axis=0)
    ends = 0
    for _ in range(401):
        assert observation.shape == (16, N_SIGNALS + N_PRIVILEGED + 3)
        np.testing.assert_array_equal(observation[:, -3:], which)
        observation, _, done, infos = env.step(np.zeros((16, 1), dtype=np.float32))
        for i in np.flatnonzero(done):
            last = infos[i]["terminal_observation"]
            assert last.shape == observation.shape[1:]
            np.testing.assert_array_equal(last[-3:], which[i])
            ends += 1
    assert ends > 3
    alone = training_env(SMALL, DriveDesign(), family(1, 1))
    assert alone.observation_space.shape == (N_SIGNALS + N_PRIVILEGED,)


def test_a_run_says_which_machines_and_is_usable_on_any(run: Path) -> None:
    config = json.loads((run / "config.json").read_text())
    facts = {
        "family": machine_family.NAME,
        "seed": 1,
        "n": 3,
        "digest": family_digest(family(1, 3)),
    }
    assert config["machines"] == facts
    assert "motor_digest" not in config
    for name in NAMES:
        policy = load_run(run, Motor.load(name))
        assert provenance(policy)["machines"] == facts
    assert provenance(policy)["motor"] == f"3 machines of {machine_family.NAME}, seed 1"


@pytest.mark.usefixtures("without_selftest")
def test_its_schedule_is_exported_for_the_machine_asked_for(run: Path, tmp_path: Path) -> None:
    table = KsTable.load(run / "table.json")
    for name in NAMES[1:]:
        motor = Motor.load(name)
        done = export(table, motor, DriveDesign(), tmp_path / name)
        known = KsTable.load(done.folder / "ks_table.json").provenance
        assert known["motor_digest"] == motor.digest
        assert known["machines"]["n"] == 3


def test_the_same_seed_gives_the_same_schedule(run: Path, tmp_path: Path) -> None:
    train(SMALL, DriveDesign(), tmp_path / "again", START)
    train(replace(SMALL, seed=2), DriveDesign(), tmp_path / "other", START)
    first, again, other = (
        [row.split(",")[2:] for row in (folder / "progress.csv").read_text().splitlines()]
        for folder in (run, tmp_path / "again", tmp_path / "other")
    )
    assert first == again != other
    tables = [KsTable.load(folder / "table.json") for folder in (run, tmp_path / "again")]
    np.testing.assert_array_equal(tables[0].values, tables[1].values)


def test_a_run_goes_on_with_its_own_machines(
    run: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = shutil.copytree(run, tmp_path / "run")
    before = len((folder / "progress.csv").read_text().splitlines())
    resume({"steps": 512}, folder)
    assert len((folder / "progress.csv").read_text().splitlines()) > before
    assert json.loads((folder / "config.json").read_text())["train"]["machines"] == 3
    known = KsTable.load(folder / "table.json").provenance
    linear_table(0.6, 0.9).save(folder / "table.json", known)
    assert "of 9 scenarios of stress-1" in judge(folder), "three a machine, of eight asked for"
    ranges = {**machine_family.RANGES, "x_d": machine_family.Range(0.25, 0.4, "another family")}
    monkeypatch.setattr(machine_family, "RANGES", ranges)
    monkeypatch.setattr(machine_family, "member", machine_family.member.__wrapped__)  # drawn anew
    with pytest.raises(
        UserError, match=r"resume: .* digest .*; it cannot continue on '3 machines of"
    ):
        resume({"steps": 512}, folder)


def test_validation_is_the_mean_over_the_machines() -> None:
    policy = make_policy("eq25", Motor.load("paper"))
    factories = [SimFactory(motor, DriveDesign()) for motor in family(1, 2)]
    costs = [validate(policy, f, 12, seed) for seed, f in enumerate(factories)]
    both = validate_all(policy, factories, 23)
    assert both.objective == pytest.approx(np.mean([cost.objective for cost in costs]))
    assert validate_all(policy, factories[:1], 12) == costs[0] != costs[1]


def test_one_machine_is_as_before() -> None:
    motor = Motor.load("paper")
    one = Machines.of(motor, TrainConfig().machines, 1)
    assert one.motors == (motor,)
    assert one.origin() == {"motor": "paper", "motor_digest": motor.digest}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (
            ["train", "--name", "x", "--machines", "257"],
            "machines: 257: must be a whole number",
        ),
        (
            ["train", "--name", "x", "--machines", "20", "--n-envs", "16"],
            "must be at most half of n_envs",
        ),
        (
            ["tune", "linear", "--machines", "300", "--out", "x.json"],
            "machines: 300: must be",
        ),
    ],
)
def test_commands_say_what_to_give(
    words: list[str], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match=said):
        CliRunner().invoke(app, words, catch_exceptions=False, standalone_mode=False)
    assert not list(tmp_path.rglob("*.json"))


def test_what_does_not_fit_is_refused(run: Path) -> None:
    with pytest.raises(UserError, match=r"machines: 9: must be at most half of n_envs = 16"):
        replace(SMALL, machines=9)
    with pytest.raises(UserError, match="machines: -1: must be a whole number between 0 and 256"):
        replace(SMALL, machines=-1)
    with pytest.raises(UserError, match=r"trained on 3 machines of .*; use a run on one motor"):
        design_and_motor(run)


def test_machines_that_the_suite_judges_on_are_no_training(motor: Motor) -> None:
    assert judged(11, 2).digest == family_digest(family(JUDGED + 11, 2))
    with pytest.raises(UserError, match="seed: 1000011; with random machines give less than"):
        Machines.of(motor, 2, JUDGED + 11)
