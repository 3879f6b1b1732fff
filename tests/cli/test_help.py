"""The help of every command, read as a user reads it."""

import dataclasses
import inspect
import math
import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import typer.main
from typer.testing import CliRunner

from sensorless.agents.train.config import TrainConfig
from sensorless.cli.app import app
from sensorless.envs.counter_random import combine
from sensorless.envs.reward import ANGLE_FREE, RewardWeights
from sensorless.envs.scenarios.stress import DURATION
from sensorless.envs.scenarios.suites import ROLES, SUITES
from sensorless.envs.window_reward import WindowWeights
from sensorless.machine.motor import MOTORS, Motor

ACTIONS = {"--help", "--install-completion", "--show-completion"}
PLAIN = {"--smoothness"}
"""Numbers without a unit."""
SUITE = r"[a-z]+(?:-\d)?"
"""Name of a suite, as a regular expression."""
VERBS = set(
    "Also Bound Call Change Charge Check Compare Count Decide Draw Evaluate Explore Feed Fit "
    "Follow Give Install Join Judge Keep Let List Map Name Pass Print Put Read Replay Report "
    "Resume Run Show Shift Simulate Smooth Start Take Trade Train Try Tune Turn Update Use "
    "Validate Visit Weigh Write Export".split()
)
"""What an option asks the command to do; its help opens with one of them."""


def commands() -> Iterator[tuple[str, Any]]:
    """Every command with its path, groups included."""
    waiting: list[tuple[str, Any]] = [("", typer.main.get_command(app))]
    while waiting:
        path, command = waiting.pop()
        yield path, command
        below = getattr(command, "commands", {})
        waiting += [(f"{path} {name}".strip(), part) for name, part in below.items()]


COMMANDS = dict(commands())


def options(path: str) -> list[Any]:
    command = COMMANDS[path]
    return [p for p in command.get_params(context(command)) if p.param_type_name == "option"]


def context(command: Any) -> Any:
    return command.make_context("sensorless", [], resilient_parsing=True)


def test_every_command_is_here() -> None:
    assert {"", "simulate", "export", "demo", "identify cross-coupling"} <= set(COMMANDS)
    assert len(COMMANDS) >= 14


@pytest.mark.parametrize("path", COMMANDS)
def test_the_help_of_a_command_teaches_by_example(path: str) -> None:
    text = inspect.cleandoc(COMMANDS[path].help)
    first = text.split("\n\n", maxsplit=1)[0]
    assert first[0].isupper() and first.endswith(".") and len(first) < 100
    examples = re.findall(r"^    sensorless (.*)$", text, re.MULTILINE)
    own = [line for line in examples if line.startswith(path)]
    assert own, "an example of the command itself"
    for line in examples:
        assert len(line) < 70, "fits a terminal of 80 columns"
        words = line.split()
        group = COMMANDS[""]
        while words and getattr(group, "commands", {}).get(words[0]) is not None:
            group = group.commands[words.pop(0)]
        group.make_context("sensorless", words, resilient_parsing=True)  # refuses unknown options


@pytest.mark.parametrize("path", COMMANDS)
def test_every_option_is_a_sentence_with_unit_and_default(path: str) -> None:
    fields = {f.name for f in dataclasses.fields(TrainConfig)} if path == "train" else set()
    for option in options(path):
        name, text = max(option.opts, key=len), option.help
        assert text and text[0].isupper() and text.endswith("."), name
        assert text.split(maxsplit=1)[0] in VERBS, f"{name}: {text}"
        assert not re.search(r"\bas in\b|allowed", text, re.IGNORECASE), name
        stated = option.required or option.default is not None or "Default: " in text
        assert stated or name in ACTIONS, f"{name}: default"
        number = option.type_descriptor.annotation is float
        plain = name in PLAIN or option.name in fields  # whose ranges have their units
        assert not number or plain or re.search(r"\[[^\]]+\]", text), f"{name}: unit"


@pytest.mark.parametrize("path", COMMANDS)
def test_the_printed_help_shows_no_type_of_a_flag_and_no_stray_bullet(path: str) -> None:
    done = CliRunner().invoke(app, [*path.split(), "--help"], env={"COLUMNS": "80"})
    assert done.exit_code == 0
    for odd in ("<bool>", "<int range>", "<float range>", "<unprocessed", "•"):
        assert odd not in done.output


def test_the_first_page_helps_a_newcomer() -> None:
    text = CliRunner().invoke(app, ["--help"], env={"COLUMNS": "80"}).output
    for word in ("HFI", "SMO", "k_s", "PPO", "--version", "--install-completion"):
        assert word in text
    for path in COMMANDS:
        assert path.split(" ")[0] in text


def test_the_help_names_every_suite_and_motor() -> None:
    (suite,) = (o for o in options("evaluate") if o.name == "suite")
    assert all(re.search(rf"\b{name}\b", suite.help) for name in SUITES)
    (motor,) = (o for o in options("evaluate") if o.name == "motor")
    assert all(path.stem in motor.help for path in MOTORS.glob("*.toml"))


def test_the_help_names_the_suite_that_a_command_uses() -> None:
    """Read from the code; imported here, as some of it needs torch."""
    from sensorless.agents.train.env import training_scenarios
    from sensorless.cli import demo_steps
    from sensorless.evaluation import machine_check, validation
    from sensorless.tuning import rule_search

    motor, seeds = Motor.load("paper"), np.arange(3, dtype=np.uint64)
    trained = training_scenarios(motor, seeds)
    for name in ("stress-1", "stress"):
        drawn = SUITES[name](motor, combine(ROLES["train"], seeds), np.arange(3), 3)
        fields = [f.name for f in dataclasses.fields(drawn)]
        same = all(np.array_equal(getattr(drawn, f), getattr(trained, f)) for f in fields)
        assert same is (name == validation.SUITE), "training and validation draw the same way"
    for path, *suites in (
        ("tune", rule_search.SUITE),
        ("train", validation.SUITE),
        ("distill", validation.SUITE),
        ("demo", demo_steps.SUITE),
        ("motor check", *machine_check.SUITES),
    ):
        texts = [COMMANDS[path].help, *(option.help or "" for option in options(path))]
        told = " ".join(" ".join(texts).split())
        named = re.findall(rf"suite ({SUITE})", told)
        for several in re.findall(rf"suites ((?:{SUITE}, )*{SUITE} and {SUITE})", told):
            named += re.split(", | and ", several)
        assert set(named) == set(suites), path
        assert not any("stress scenarios" in text for text in texts), path


def test_the_help_of_train_has_the_figures_of_the_code() -> None:
    helps = {option.name: option.help for option in options("train")}
    config, weights = TrainConfig(), RewardWeights()

    def figures(name: str, pattern: str) -> list[float]:
        found = re.search(pattern, helps[name])
        assert found is not None, name
        return [float(x) for x in found.groups()]

    assert figures("n_steps", r"(\d+) of (\d+) ms") == [config.n_steps, config.decision_ms]
    assert config.n_steps * config.decision_ms == 1e3 * DURATION, "a whole scenario"
    worst, of, gains = figures(
        "lost_penalty", r"(\d+) in a scenario of (\d+) s.* (\d+) with --gains"
    )
    assert of == DURATION
    without_angle = weights.worst_running - weights.angle
    assert worst == pytest.approx(1e3 * DURATION * without_angle, abs=0.5)
    beside = WindowWeights().worst_running - WindowWeights().angle
    assert gains == pytest.approx(1e3 * DURATION * beside, abs=0.5)
    assert figures("angle_cost", r"begins at (\d+) degrees") == [math.degrees(ANGLE_FREE)]


def test_version() -> None:
    done = CliRunner().invoke(app, ["--version"])
    assert done.exit_code == 0
    assert re.fullmatch(r"sensorless .+, core [0-9a-f]{16}, Python 3\.\d+\.\d+\n", done.output)
