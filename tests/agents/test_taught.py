"""What a table is taught, on which states, and which of the tables is kept."""

import math
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from typer.testing import CliRunner

from sensorless.agents import distill as module
from sensorless.agents.distill import Distilled, distill, refuse_memory
from sensorless.agents.table.fit import TableFit
from sensorless.cli.app import app
from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.errors import UserError
from sensorless.evaluation.validation import validate
from sensorless.machine.motor import Motor
from sensorless.policy import NO_SETTINGS, Settings
from sensorless.table.ks_table import Axis

MOTOR = Motor.load("paper")
FACTORY = SimFactory(MOTOR, DriveDesign())
AXES = (Axis("speed", 0.0, 1.0, 5),)
Signals = NDArray[np.float32]


class Curve:
    """k_s falls with the speed, along a curve that five nodes miss."""

    sensored, name = False, "curve"
    settings: Settings = NO_SETTINGS

    def reset(self, n: int) -> None:
        pass

    def act(self, obs: Signals) -> Signals:
        return np.asarray(np.exp(-4.0 * np.abs(obs[:, 0])), dtype=np.float32)


@pytest.fixture
def samples(monkeypatch: pytest.MonkeyPatch) -> list[tuple[Signals, Signals]]:
    """Signals and wanted weights as the fit gets them."""
    got: list[tuple[Signals, Signals]] = []

    class Watched(TableFit):
        def add(self, obs: Signals, k_s: Signals) -> None:
            got.append((obs.copy(), k_s.copy()))
            super().add(obs, k_s)

    monkeypatch.setattr(module, "TableFit", Watched)
    return got


def taught(rounds: int, costs: list[float] | None = None) -> Distilled:
    told = costs if costs is not None else []
    return distill(
        Curve(), AXES, FACTORY, rounds=rounds, size=8, seed=1, smoothness=1e-6,
        validate_size=16, report=lambda j, rms, cost: told.append(cost.objective),
    )  # fmt: skip


@pytest.mark.usefixtures("brief")
def test_the_teacher_decides_in_states_of_new_scenarios(
    samples: list[tuple[Signals, Signals]],
) -> None:
    """Also where the table runs, and the difference told is that in its states."""
    found = taught(1)
    assert len(samples) % 2 == 0
    first, second = np.split(np.arange(len(samples)), 2)
    for obs, k_s in samples:
        assert np.array_equal(k_s, Curve().act(obs)) and np.isfinite(obs).all()
    assert not np.array_equal(samples[first[0]][0], samples[second[0]][0])
    obs = np.concatenate([samples[j][0] for j in second])
    off = found.table.evaluate(obs) - Curve().act(obs)
    assert found.rms == pytest.approx(np.sqrt(np.mean(off.astype(float) ** 2)), rel=1e-5)
    assert found.rms > 0.01


@pytest.mark.usefixtures("brief")
def test_every_fifth_decision_is_a_sample(samples: list[tuple[Signals, Signals]]) -> None:
    """Of both rounds, each of 0.2 s; the eight drives begin alike."""
    taught(1)
    decisions = 0.2 / (decision_periods(MOTOR) * MOTOR.T_s)
    assert len(samples) == 2 * math.ceil(decisions / 5)
    assert len(samples[0][0]) == 8


@pytest.mark.usefixtures("brief")
def test_the_table_that_validates_best_is_kept() -> None:
    costs: list[float] = []
    found = taught(3, costs)
    assert len(costs) == 3 and len(set(costs)) > 1
    assert found.cost.objective == min(costs)
    judged = validate(Curve(), FACTORY, 16)
    assert found.network == judged != found.cost
    facts = found.facts()
    assert facts["network_validation"] == asdict(judged)
    assert facts["validation"] == asdict(found.cost)


def test_a_trace_of_memory_is_refused() -> None:
    """A weight that moves by a hundredth with the past is not that of the moment."""

    class Slow(Curve):
        last = np.float32(0.0)

        def act(self, obs: Signals) -> Signals:
            out = np.asarray(0.5 + 0.01 * self.last + 0.0 * obs[:, 0], dtype=np.float32)
            self.last = obs[0, 0]
            return out

    refuse_memory(Curve())
    with pytest.raises(UserError, match="without memory"):
        refuse_memory(Slow())


def test_the_words_of_the_command_reach_the_fit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "taught_own.py").write_text(
        "class Flat:\n    def __init__(self, motor): pass\n"
        "    def act(self, obs): return 0.5 + 0 * obs[:, 0]\n"
    )
    got: dict[str, Any] = {}

    def stop(teacher: object, axes: object, factory: object, **words: Any) -> None:
        got.update(words, axes=axes)
        raise UserError("enough")

    monkeypatch.setattr(module, "distill", stop)
    words = "--rounds 3 --size 9 --seed 7 --smoothness 0.5 --validate-size 17 --name t"
    CliRunner().invoke(
        app, ["distill", "taught_own:Flat", *words.split(), "--axes", "speed:0:0.5:6"]
    )
    assert got.pop("axes") == (Axis("speed", 0.0, 0.5, 6),) and callable(got.pop("report"))
    assert got == {"rounds": 3, "size": 9, "seed": 7, "smoothness": 0.5, "validate_size": 17}
