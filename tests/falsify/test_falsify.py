"""A search finds losses, each comes back by its word, and what it needs is enough to lose it."""

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.finds import HARD, REMOVABLE, load, scenarios_of
from sensorless.envs.scenarios.machines_suite import machine
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.envs.scenarios.words import found_elsewhere, own_machine, scenario_from
from sensorless.errors import UserError
from sensorless.falsify.search import Search, search, severity
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

PAPER = Motor.load("paper")
SMO = SimFactory(PAPER, DriveDesign(estimator="smo"))
EQ25 = make_policy("eq25", PAPER)


def test_what_a_search_finds_comes_back_by_its_word(tmp_path: Path) -> None:
    """The SMO loses half of ``low-inertia``; a few of the fields suffice for one of them."""
    out = tmp_path / "finds.json"
    words = ["falsify", "eq25", "--set", "estimator=smo", "--suite", "low-inertia"]
    done = CliRunner().invoke(app, [*words, "--size", "128", "--out", str(out)])
    assert done.exit_code == 0, done.output
    facts, (find,) = json.loads(out.read_text(encoding="utf-8")), load(out)
    assert facts["scenarios"] == facts["sampled"] == 128 and facts["lost"] > 30
    for word in (f"{out}:0", f"{out}:0:min"):
        score, when = severity(EQ25, scenario_from(word, PAPER), SMO)
        assert np.isfinite(when[0]) and score[0] > 200.0
        if not word.endswith("min"):
            assert when[0] == find.lost_at and score[0] == pytest.approx(find.severity)
    assert set(find.nominal) < set(REMOVABLE) and len(find.nominal) > 5
    with pytest.raises(UserError, match="has 1 scenarios"):
        scenario_from(f"{out}:1", PAPER)
    assert found_elsewhere(f"{out}:0", PAPER, "smo") == found_elsewhere("hold:1:2", PAPER, "") == ""
    done = CliRunner().invoke(app, ["simulate", "--scenario", f"{out}:0"])
    said = "found on motor paper with estimator=smo; this run is on paper with estimator=coupled"
    assert done.exit_code == 0 and said in " ".join(done.output.split())
    facts["finds"][0]["lost_at"] = None
    out.write_text(json.dumps(facts), encoding="utf-8")
    with pytest.raises(UserError, match="0 was not lost; leave out :min"):
        scenario_from(f"{out}:0:min", PAPER)


def test_a_find_on_a_random_machine_comes_back_on_it(tmp_path: Path) -> None:
    """The SMO loses a third of these; the file names the machine of each search."""
    out = tmp_path / "finds.json"
    words = ["falsify", "eq25", "--set", "estimator=smo", "--suite", "machines"]
    done = CliRunner().invoke(app, [*words, "--size", "200", "--seed", "5", "--out", str(out)])
    assert done.exit_code == 0, done.output
    finds = load(out)
    assert {find.machine for find in finds} <= {(5, i) for i in range(2)}
    for i, find in enumerate(finds):
        motor, word = own_machine(f"{out}:{i}")
        assert motor is not None and find.machine is not None
        assert motor.digest == machine(*find.machine).digest
        factory = SimFactory(motor, DriveDesign(estimator="smo"))
        score, _ = severity(make_policy("eq25", motor), scenario_from(word, motor), factory)
        assert score[0] == pytest.approx(find.severity)


def test_ctrl_c_keeps_the_searches_that_have_ended() -> None:
    def stop(found: Search) -> None:
        raise KeyboardInterrupt

    found = search(EQ25, SMO, "low-inertia", 1, 2000, stop)
    assert found.interrupted and len(found.finds) == found.searches == 1


def test_a_search_climbs() -> None:
    """Nothing is lost on the coupled observer, but the worst angle error grows on the way."""
    factory = SimFactory(PAPER, DriveDesign())
    worst = [search(EQ25, factory, "stress", 3, n).finds[0].severity for n in (128, 192)]
    assert 5.0 < worst[0] < worst[1]


def test_a_search_leaves_the_generator_of_numpy_alone() -> None:
    before = np.random.get_state()[1].tolist()  # type: ignore[index]
    search(EQ25, SimFactory(PAPER, DriveDesign()), "stress", 3, 192)
    assert np.random.get_state()[1].tolist() == before  # type: ignore[index]


def test_the_shipped_finds_are_split_in_halves() -> None:
    """Later rows are neighbours of the first ones."""
    found = load(HARD)
    half = len(found[0::2])
    judged, trained = suite("hard", PAPER, 1, half + 1), suite("hard-train", PAPER, 1, half - 1)
    assert not set(judged.theta_0) & set(trained.theta_0)
    assert np.array_equal(judged.J[:half], scenarios_of(found[0::2], PAPER).J)
    assert judged.J[half] != judged.J[0] and judged.J[half] == pytest.approx(judged.J[0], rel=0.05)


MACHINE = (
    '{"finds": [{"suite": "stress-1", "seed": 1, "units": [0.5], "severity": 9, "lost_at": null, '
    '"nominal": [], "machine": ["a"]}]}'
)
SEEDS = [MACHINE.replace('"seed": 1', f'"seed": {n}').replace('["a"]', "null") for n in (-1, 2**80)]
NUMBERS = [MACHINE.replace("0.5", x).replace('["a"]', "null") for x in ("NaN", "1e20", "1" * 400)]
SUITES = [MACHINE.replace("stress-1", x).replace('["a"]', "null") for x in ("hold", "none")]
NAMES = [MACHINE.replace("[]", x).replace('["a"]', "null") for x in ('["x"]', "[1]", "3")]


@pytest.mark.parametrize(
    "text",
    ["", "{}", '{"finds": [{"suite": "stress"}]}', MACHINE, *SEEDS, *NUMBERS, *SUITES, *NAMES],
)
def test_another_file_is_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(UserError, match="not a file of sensorless falsify"):
        scenario_from(f"{path}:0", PAPER)


@pytest.mark.parametrize(
    ("words", "said"),
    [(["sensored"], "knows the truth"), (["oracle"], "knows the truth"),
     (["eq25", "--seed", str(2**63)], "seed"), (["eq25", "--suite", "hold"], "cannot be searched")],
)  # fmt: skip
def test_a_mistake_is_named_and_writes_no_file(words: list[str], said: str, tmp_path: Path) -> None:
    out = tmp_path / "finds.json"
    done = CliRunner().invoke(app, ["falsify", *words, "--size", "128", "--out", str(out)])
    assert isinstance(done.exception, UserError) and said in str(done.exception)
    assert not out.exists()


def test_a_file_of_something_else_is_not_replaced(tmp_path: Path) -> None:
    out = tmp_path / "rule.json"
    out.write_text('{"rule": "linear"}', encoding="utf-8")
    done = CliRunner().invoke(app, ["falsify", "eq25", "--size", "200", "--out", str(out)])
    assert isinstance(done.exception, UserError) and "not a file of" in str(done.exception)
    assert out.read_text(encoding="utf-8") == '{"rule": "linear"}'


def test_without_the_library_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "cma", None)
    with pytest.raises(UserError, match=r"falsify needs .* pip install 'sensorless\[tune\]'"):
        search(EQ25, SMO, "low-inertia", 1, 128)
