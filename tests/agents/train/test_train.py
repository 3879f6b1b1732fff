"""Training from start to a usable schedule, interrupted and resumed."""

import dataclasses
import itertools
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import typer
from torch.optim import Adam

from sensorless.agents.loading import load_run
from sensorless.agents.table.module import TableModule
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.env import stream
from sensorless.agents.train.train import resume, train
from sensorless.baselines.linear import EQ25_BAND, linear_table
from sensorless.cli.train import run_training
from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.evaluation.objective import Cost
from sensorless.evaluation.validation import validate_all
from sensorless.machine.motor import MOTORS, Motor
from sensorless.policies.registry import table_named

pytestmark = pytest.mark.usefixtures("brief")


SMALL = TrainConfig(
    n_envs=16, n_steps=16, batch_size=128, n_epochs=1, steps=1024, warm_up=1, validate_size=16
)
MOTOR = Motor.load("paper")
START = table_named("eq25", MOTOR)


def test_start_is_an_exact_copy_of_eq25() -> None:
    table = SMALL.start_table(table_named("eq25", MOTOR), MOTOR, 50.0)
    rng = np.random.default_rng(0)
    obs = rng.uniform(-1.5, 1.5, (2000, SIGNAL_N)).astype(np.float32)
    obs[:, SIGNAL_NAMES.index("speed")] = rng.uniform(0.0, 1.5, 2000)
    eq25 = linear_table(*EQ25_BAND).evaluate(obs)
    np.testing.assert_allclose(table.evaluate(obs), eq25, atol=2e-6)
    assert 0.0 < eq25.mean() < 1.0


def test_a_run_can_be_used_and_gone_on_with(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    seen: list[int] = []
    train(
        SMALL, DriveDesign(), folder, START, report=lambda share, steps, found: seen.append(steps)
    )
    assert seen[-1] >= SMALL.steps
    policy = load_run(folder, MOTOR)
    obs = np.zeros((3, SIGNAL_N), dtype=np.float32)
    k_s = policy.act(obs)
    assert ((k_s >= 0.0) & (k_s <= 1.0)).all()
    config = json.loads((folder / "config.json").read_text())
    assert config["motor_digest"] == MOTOR.digest
    assert config["train"]["seed"] == SMALL.seed
    assert (folder / "progress.csv").is_file()
    again: list[int] = []
    resume(
        {"steps": SMALL.steps},
        folder,
        report=lambda share, steps, found: again.append(steps),
    )
    assert again[0] >= seen[-1], "a resumed run goes on counting"
    assert again[-1] >= seen[-1] + SMALL.steps


@pytest.mark.parametrize("last", [False, True])
def test_it_keeps_the_best_table_or_the_last(
    last: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each validation is made to look worse than the one before."""
    worse = itertools.count(1.0)
    monkeypatch.setattr(
        "sensorless.agents.train.watch.validate_all",
        lambda *args: replace(validate_all(*args), torque_dev=next(worse)),
    )
    train(replace(SMALL, last=last), DriveDesign(), tmp_path / "run", START)
    rows = (tmp_path / "run/progress.csv").read_text().splitlines()[1:]
    first, *_, end = ([float(x) for x in row.split(",")] for row in rows)
    assert end[-2] > first[-2] and end[0] > first[0]
    kept = json.loads((tmp_path / "run/table.json").read_text())["provenance"]["steps"]
    assert kept == (end if last else first)[0]


def test_training_moves_the_table(tmp_path: Path) -> None:
    last: list[Cost] = []

    def keep(share: float, steps: int, found: Cost | None) -> None:
        last.extend([found] if found else [])

    wide = dataclasses.replace(SMALL, start="linear:100,900")  # at once between 0 and 1
    train(wide, DriveDesign(), tmp_path / "run", START, report=keep)
    from stable_baselines3 import PPO

    model = PPO.load(tmp_path / "run" / "checkpoints" / "latest.zip", device="cpu")
    moved = model.policy.actor.values.detach()  # type: ignore[operator, union-attr]
    start = TableModule(wide.start_table(table_named("eq25", MOTOR), MOTOR, 50.0)).values.detach()
    assert not np.array_equal(moved.numpy(), start.numpy())
    assert min(v.objective for v in last) <= last[0].objective


def test_interrupt_keeps_a_checkpoint(tmp_path: Path) -> None:
    def stop(share: float, steps: int, found: Cost | None) -> None:
        if steps >= 512:
            raise KeyboardInterrupt

    folder = tmp_path / "run"
    with pytest.raises(KeyboardInterrupt):
        train(SMALL, DriveDesign(), folder, START, report=stop)
    load_run(folder, MOTOR)
    assert not list(folder.rglob("*part*"))
    resume({"steps": SMALL.steps}, folder)


def test_the_way_on_after_an_interrupt_is_quoted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*args: object, **how: object) -> None:
        (folder / "config.json").touch()
        raise KeyboardInterrupt

    (folder := tmp_path / "a b").mkdir()
    monkeypatch.setattr("sensorless.agents.train.train.train", interrupted)
    with pytest.raises(typer.Exit):
        run_training(SMALL, {}, folder)
    assert f"--resume '{folder}'" in capsys.readouterr().err


def test_steps_of_the_optimiser_end_where_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    seen: list[list[float]] = []
    step = Adam.step

    def watched(self: Adam, closure: None = None) -> object:
        seen.append([group["lr"] for group in self.param_groups])
        return step(self, closure)

    monkeypatch.setattr(Adam, "step", watched)
    train(replace(SMALL, lr_end=0.1), DriveDesign(), tmp_path / "run", START)
    np.testing.assert_allclose(seen[0], [SMALL.lr_nodes, SMALL.lr_critic])
    np.testing.assert_allclose(np.array(seen[-1]) / seen[0], 1.0 - 0.9 * 0.75)  # four updates
    assert (np.diff(np.array(seen), axis=0) <= 0.0).all()


def other_motor(folder: Path) -> Path:
    """The paper's machine with another resistance."""
    text = (MOTORS / "paper.toml").read_text()
    path = folder / "other.toml"
    path.write_text(text.replace("R_s = 2.484", "R_s = 2.5", 1))
    return path


def test_a_run_of_another_motor_is_refused(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    train(SMALL, DriveDesign(), folder, START)
    path = other_motor(tmp_path)
    with pytest.raises(UserError, match="digest"):
        load_run(folder, Motor.load(path))
    config = json.loads((folder / "config.json").read_text())
    config["train"]["motor"] = str(path)
    with pytest.raises(UserError, match="digest"):
        resume({"motor": str(path), "steps": 64}, folder)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"ripple_cost": 3.0}, "ripple_cost: 3: only for training with --gains"),
        ({"policy_kind": "mlp", "smoothness": 3.0}, "smoothness: 3: only for a table"),
        ({"policy_kind": "mlp", "margin": 0.5}, "margin: 0.5: only for a table"),
        ({"policy_kind": "mlp", "lr_nodes": 0.1}, "lr_nodes: 0.1: only for a table"),
    ],
)
def test_what_a_run_would_not_read_is_refused(
    given: dict[str, Any], said: str, tmp_path: Path
) -> None:
    with pytest.raises(UserError, match=said):
        train(replace(SMALL, **given), DriveDesign(), tmp_path / "run", START)
    assert not (tmp_path / "run").exists()


def test_a_folder_in_use_is_refused(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(UserError, match="exists"):
        train(SMALL, DriveDesign(), tmp_path, START)
    assert (tmp_path / "notes.txt").read_text() == "mine"


def test_a_mistake_leaves_no_folder(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="not a node"):
        train(
            replace(SMALL, start="linear:310,400", axes="speed:0:1:16"),
            DriveDesign(),
            tmp_path / "run",
            table_named("linear:310,400", Motor.load("paper")),
        )
    assert not (tmp_path / "run").exists()


def test_runs_share_no_scenarios() -> None:
    starts = sorted(stream(seed, step) for seed in range(40) for step in (0, 4096))
    assert min(b - a for a, b in itertools.pairwise(starts)) > 65536
