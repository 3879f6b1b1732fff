"""From a network to a table: the fit, the states it is fitted on, and the command."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from sensorless.agents.distill import distill
from sensorless.agents.mlp.schedule import LAYERS, MlpSchedule
from sensorless.agents.table.fit import SNAP, TableFit, roughness
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.train import train
from sensorless.baselines.linear import EQ25_BAND, linear_table
from sensorless.cli.app import app
from sensorless.core.api import SIGNAL_N
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import UserError
from sensorless.export.export import export
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy, table_named
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import Axis, KsTable
from sensorless.table.standstill import even_at_standstill

MOTOR = Motor.load("paper")
START = table_named("eq25", MOTOR)
AXES = (Axis("speed", 0.0, 1.0, 16), Axis("torque_current", -1.5, 1.5, 3))


def teacher(seed: int = 0, size: float = 0.6) -> MlpSchedule:
    """Eq. 25 and a smooth correction of it by speed and torque current."""
    rng = np.random.default_rng(seed)
    shapes = ((SIGNAL_N, 8), (8,), (8, 8), (8,), (8, 1), (1,))
    layers = {
        k: rng.normal(0.0, size, s).astype(np.float32) for k, s in zip(LAYERS, shapes, strict=True)
    }
    layers["w0"][2:] = 0.0  # only the signals of AXES
    return MlpSchedule("net", linear_table(*EQ25_BAND), layers)


def observations(n: int) -> np.ndarray[tuple[int, int], np.dtype[np.float32]]:
    rng = np.random.default_rng(1)
    obs = rng.uniform(-1.5, 1.5, (n, SIGNAL_N)).astype(np.float32)
    obs[:, 0] = rng.uniform(0.0, 1.0, n)
    return obs


def test_the_fit_finds_a_table_again() -> None:
    rng = np.random.default_rng(2)
    values = np.clip(rng.uniform(-0.5, 1.5, (16, 3)), 0.0, 1.0).astype(np.float32)
    values = even_at_standstill(values, AXES)
    source, fit, obs = KsTable(AXES, values), TableFit(AXES, 0.0), observations(4000)
    for part in np.split(obs, 4):
        fit.add(part, source.evaluate(part))
    found = fit.solve(50.0)
    between = (values > SNAP + 0.01) & (values < 1.0 - SNAP - 0.01)
    np.testing.assert_allclose(found.values[between], values[between], atol=2e-3)
    for end in (0.0, 1.0):
        assert (values == end).any() and (found.values[values == end] == end).all()


def test_smoothness_fills_what_was_never_visited() -> None:
    fit, obs = TableFit(AXES, 1e-3), observations(4000)
    obs[:, 0] *= 0.5
    fit.add(obs, (1.0 - obs[:, 0]).astype(np.float32))
    found = fit.solve(50.0)
    assert np.abs(found.values - (1.0 - AXES[0].nodes[:, None])).max() < 0.02


def test_roughness_knows_lines_from_bends() -> None:
    line = np.add.outer(np.arange(5.0), 2.0 * np.arange(4.0)).ravel()
    matrix = roughness((5, 4))
    assert abs(line @ matrix @ line) < 1e-9
    bend = line.copy()
    bend[7] += 1.0
    assert bend @ matrix @ bend > 1.0


@pytest.mark.usefixtures("brief")
def test_a_table_follows_the_network_and_says_how_far() -> None:
    net, rounds = teacher(), []
    net.layers["w0"][1] = 0.0  # at standstill no table follows the sign of the torque current
    fine = (Axis("speed", 0.0, 1.2, 31), Axis("torque_current", -1.5, 1.5, 9))
    found = distill(
        net, fine, SimFactory(MOTOR, DriveDesign()), rounds=2, size=24, seed=1, smoothness=1e-4,
        validate_size=16, report=lambda j, rms, cost: rounds.append((j, rms)),
    )  # fmt: skip
    obs = observations(3000)
    far = np.sqrt(np.mean((net.start.evaluate(obs) - net.act(obs)) ** 2))
    assert [j for j, _ in rounds] == [1, 2]
    assert 0.0 < found.rms < 0.1 * far
    assert found.rms in [rms for _, rms in rounds]


@pytest.mark.usefixtures("brief")
def test_the_same_words_give_the_same_table() -> None:
    tables = [
        distill(
            teacher(), AXES, SimFactory(MOTOR, DriveDesign()), rounds=1, size=8, seed=seed,
            smoothness=1e-3, validate_size=16,
        ).table.values.tobytes()
        for seed in (1, 1, 2)
    ]  # fmt: skip
    assert tables[0] == tables[1] != tables[2]


@pytest.mark.usefixtures("brief")
def test_a_network_is_taught_on_its_own_estimator() -> None:
    """Network, table and the states of the fit, whatever the design of the factory says."""
    found = []
    for own, given in (("flux", "smo"), (None, "flux"), (None, "smo")):
        net, factory = teacher(), SimFactory(MOTOR, DriveDesign(estimator=given))
        net.settings = {"estimator": own} if own else {}
        found.append(
            distill(net, AXES, factory, rounds=1, size=8, seed=1, smoothness=1e-3, validate_size=16)
        )
    flux, same, smo = ((d.table.digest, d.rms, d.network, d.cost) for d in found)
    assert flux == same != smo


@pytest.mark.usefixtures("brief", "without_selftest")
def test_the_command_writes_a_run_that_exports(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    config = TrainConfig(
        policy_kind="mlp", n_envs=16, n_steps=16, n_epochs=1, steps=512, warm_up=1,
        validate_size=16,
    )  # fmt: skip
    train(config, DriveDesign(signal_hz=40.0), tmp_path / "runs" / "net", START)
    words = "--rounds 1 --size 8 --validate-size 16 --name table --axes speed:0:1:16".split()
    result = CliRunner().invoke(app, ["distill", "runs/net", *words])
    assert result.exit_code == 0, result.output
    policy = make_policy("runs/table", MOTOR)
    assert isinstance(policy, TablePolicy)
    facts = json.loads((tmp_path / "runs/table/table.json").read_text())["provenance"]
    assert policy.table.values.shape == (16,)
    assert facts["design"]["signal_hz"] == 40.0 and facts["k_s_rms"] >= 0.0
    assert facts["network_validation"].keys() == facts["validation"].keys()
    done = export(policy.table, MOTOR, DriveDesign(), tmp_path / "firmware")
    assert done.files
    again = CliRunner().invoke(app, ["distill", "runs/net", *words])
    assert isinstance(again.exception, UserError)
    assert str(again.exception).endswith("already exists; choose a new name")
    other = CliRunner().invoke(app, ["distill", "runs/table", "--name", "twice"])
    assert isinstance(other.exception, UserError)


OWN = """
class Slower:
    settings = {"estimator": "flux"}
    def __init__(self, motor): pass
    def act(self, obs): return (1.5 - 2 * obs[:, 0]).clip(0, 1)

class Louder(Slower):
    from sensorless.core.gains import DEFAULT as ranges
    def act_gains(self, obs): return 0

class Lagging(Slower):
    k_s = 1.0
    def reset(self, n): self.k_s = 1.0
    def act(self, obs):
        self.k_s = 0.9 * self.k_s + 0.1 * Slower.act(self, obs)
        return self.k_s
"""


@pytest.mark.usefixtures("brief")
def test_a_policy_in_python_becomes_a_table(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "distilled_own.py").write_text(OWN)
    words = "--rounds 1 --size 8 --validate-size 16 --smoothness 1e-6 --name table".split()

    def run(name: str, *more: str) -> Result:
        return CliRunner().invoke(app, ["distill", f"distilled_own:{name}", *words, *more])

    none = run("Slower")
    assert isinstance(none.exception, UserError) and "give --axes, for" in str(none.exception)
    gains = run("Louder", "--axes", "speed:0:1:17")
    assert isinstance(gains.exception, UserError) and "sets k_s alone" in str(gains.exception)
    lagging = run("Lagging", "--axes", "speed:0:1:17")
    assert isinstance(lagging.exception, UserError) and "Lagging" in str(lagging.exception)
    assert "without memory" in str(lagging.exception) and not (tmp_path / "runs/table").exists()
    done = run("Slower", "--axes", "speed:0:1:17")
    assert done.exit_code == 0 and "Slower: lost" in done.output, done.output
    policy = make_policy("runs/table", MOTOR)
    assert isinstance(policy, TablePolicy) and policy.settings["estimator"] == "flux"
    np.testing.assert_allclose(policy.table.values[4:9], 1.5 - np.arange(4, 9) / 8, atol=0.05)
    facts = json.loads((tmp_path / "runs/table/table.json").read_text())["provenance"]
    assert facts["distilled_from"] == {"policy": "distilled_own:Slower"}
