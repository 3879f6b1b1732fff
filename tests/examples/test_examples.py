"""Every example runs, at a small size, and says what it promises."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from stable_baselines3 import PPO

from sensorless.agents.train.sb3_adapter import SB3VecEnv
from sensorless.core.api import SIGNAL_N
from sensorless.core.gains import DEFAULT, GAIN_NAMES
from sensorless.envs.blend_v1 import GainVectorEnv
from sensorless.envs.returns import acts, returns
from sensorless.envs.signals import bounded
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import GainPolicy, gains_of
from tests.helpers.script import ROOT, script

pytestmark = pytest.mark.usefixtures("short_suites")

EXAMPLES = ROOT / "examples"
SCREEN = 80
"""Most lines of an example: one screen."""
RUNS = {
    "own_rule": (["--size", "4"], "more-under-load"),
    "own_motor": (["--size", "2", "--out", "hub.toml"], "suits this drive: yes"),
    "evaluate_from_python": (["--size", "4"], "under reference: kept lock"),
    "replay_a_log": (["--after", "0.5"], "estimator=smo"),
    "flash": (["--out", "firmware"], "self test"),
}
"""Small arguments and words of the output by example."""


@pytest.mark.usefixtures("without_ekf")
@pytest.mark.parametrize("name", RUNS)
def test_an_example_runs(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    words, promised = RUNS[name]
    script(f"examples/{name}.py").main(words)
    assert promised in capsys.readouterr().out


@pytest.mark.parametrize("gains", [(), tuple(DEFAULT)], ids=["k_s", "gains"])
def test_a_model_of_stable_baselines3_is_a_policy(
    gains: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    env = SB3VecEnv(GainVectorEnv(2, autoreset_mode="SameStep", gains=gains))
    model = PPO("MlpPolicy", env, n_steps=2, batch_size=2, device="cpu")
    model.save(tmp_path / "ppo.zip")
    monkeypatch.syspath_prepend(str(ROOT))
    monkeypatch.chdir(tmp_path)
    policy = make_policy("examples.own_policy:Model", Motor.load("paper"))
    obs = bounded(np.linspace(-1.0, 1.0, 2 * SIGNAL_N, dtype=np.float32).reshape(2, SIGNAL_N))
    action = model.predict(obs, deterministic=True)[0]
    assert policy.act(obs) == pytest.approx(0.5 + 0.5 * action[:, 0])
    assert tuple(gains_of(policy)) == gains
    if isinstance(policy, GainPolicy) and gains:
        columns = [GAIN_NAMES.index(name) for name in gains]
        assert policy.act_gains(obs)[:, columns] == pytest.approx(action[:, 1:])


def test_a_model_that_is_not_there_yet_is_asked_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(str(ROOT))
    monkeypatch.chdir(tmp_path)
    with pytest.raises(UserError, match=r"ppo\.zip: no such file here; first run: python examples"):
        make_policy("examples.own_policy:Model", Motor.load("paper"))


def test_the_example_knows_what_eq25_earns() -> None:
    """The number that its own text sets beside that of PPO."""
    judge = GainVectorEnv(1024, gains=())
    earned = returns(judge, acts(make_policy("eq25", judge.batch.motor), judge), 10**6).mean()
    text = (EXAMPLES / "ppo.py").read_text(encoding="utf-8")
    assert f"where Eq. 25 has {earned:.1f}," in text


@pytest.mark.parametrize("words", ["--help", "many", "0"])
@pytest.mark.parametrize("name", ["ppo", "sac"])
def test_what_an_example_takes_is_told(name: str, words: str, tmp_path: Path) -> None:
    """Before it makes an environment."""
    command = [sys.executable, str(EXAMPLES / f"{name}.py"), words]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    told = done.stdout if words == "--help" else done.stderr
    assert done.returncode == (0 if words == "--help" else 2) and told.startswith("usage:")
    assert "Traceback" not in told and not list(tmp_path.iterdir())


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_an_example_fits_on_a_screen(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= SCREEN
