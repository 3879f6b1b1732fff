"""Every command line that the documentation shows is one: parsed, never run."""

import re
from pathlib import Path
from typing import Any

import pytest
import typer.main

from sensorless.cli.app import app
from sensorless.design.words import design_from
from sensorless.envs.scenarios.machines_suite import NAME as MACHINES
from sensorless.envs.scenarios.suites import SUITES
from sensorless.machine.motor import MOTORS, Motor
from sensorless.policies.registry import make_policy
from tests.helpers.documentation import PAGES, ROOT, shown

MAKEFILES = ("Makefile", "firmware/Makefile", "firmware/selftest.mk")

COMMANDS = [(page, words, whole) for page in PAGES for words, whole in shown(page)]


def is_file(word: str) -> bool:
    """Names a file or folder that the reader made, not a policy or motor of the package."""
    return "/" in word or word.endswith((".json", ".toml"))


SENSORLESS: Any = typer.main.get_command(app)


def check_sensorless(words: list[str], whole: bool) -> None:
    """Command, options and the names among their values exist; a whole one lacks no argument."""
    command = SENSORLESS
    while words and (known := getattr(command, "commands", {})):
        n = next((n for n in (2, 1) if " ".join(words[:n]) in known), 0)
        if not n:
            break
        command, words = known[" ".join(words[:n])], words[n:]
    assert not words or not hasattr(command, "commands") or words[0].startswith("-"), words[0]
    try:
        given = command.make_context("sensorless", words, resilient_parsing=not whole).params
    except typer.Exit:  # of --list or --version
        return
    design_from(given.get("settings"))
    for name in [given.get("suite")] if isinstance(given.get("suite"), str) else []:
        assert name in (*SUITES, MACHINES)
    motor = given.get("motor") or "paper"
    assert is_file(motor) or (MOTORS / f"{motor}.toml").is_file(), motor
    policies = given.get("policy") or []
    for policy in [policies] if isinstance(policies, str) else policies:
        if not is_file(policy):
            make_policy(policy, Motor.load("paper"))


def check_make(words: list[str], whole: bool) -> None:
    """Every target is one of some makefile of the project."""
    known = {"-f"}
    for name in MAKEFILES:
        text = (ROOT / name).read_text(encoding="utf-8")
        known |= {
            t for line in re.findall(r"^([\w -]+):", text, re.MULTILINE) for t in line.split()
        }
    for word in words:
        assert word in known or word.startswith("-j") or "=" in word or is_file(word), word


def check_python(words: list[str], whole: bool) -> None:
    """The script or module exists and knows the options."""
    if words[0] == "-c":
        compile(words[1], "documentation", "exec")
        return
    module = words[0] == "-m"
    name = words[1] if module else words[0]
    if name in ("pip", "pytest", "venv"):
        return
    script = ROOT / (name.replace(".", "/") + ".py" if module else name)
    assert script.is_file(), name
    source = script.read_text(encoding="utf-8")
    for word in words:
        assert not word.startswith("--") or f'"{word}"' in source, word


def check_pytest(words: list[str], whole: bool) -> None:
    """The tests exist."""
    for word in words:
        assert "/" not in word or (ROOT / word).exists(), word


CHECKS = {
    "sensorless": check_sensorless,
    "make": check_make,
    "python": check_python,
    "pytest": check_pytest,
}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_commands_of_a_page_exist(page: Path) -> None:
    """The parser or the assertion names the one that does not."""
    for of, words, whole in COMMANDS:
        if of != page:
            continue
        program = words[0].removeprefix(".venv/bin/")
        if program in CHECKS:
            CHECKS[program](words[1:], whole)
        else:
            assert program in ("pip", "pre-commit", "ruff", "mypy"), words


def test_there_are_commands_to_check() -> None:
    first = [words[0] for _, words, _ in COMMANDS]
    assert first.count("sensorless") > 40 and first.count("make") > 5 and first.count("python") > 5


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("sensorless trian --name first", "trian"),
        ("sensorless train --nmae first", "No such option: --nmae"),
        ("sensorless train --name", "Option '--name' requires an argument"),
        ("sensorless export runs/first", "Missing parameter: out"),
        ("sensorless train --name first --set smo_pll=30", "no such setting"),
        ("sensorless evaluate --policy eq52", "'eq52' is not a rule, folder or file"),
        ("sensorless evaluate --policy eq25 --suite strss", "strss"),
        ("sensorless simulate --motor papr", "papr"),
        ("make tset", "tset"),
        ("python studies/axis_study.py", "studies/axis_study.py"),
        ("python studies/axes_study.py --sedes 1", "--sedes"),
        ("pytest tests/core/test_batch.py", "tests/core/test_batch.py"),
    ],
)
def test_a_wrong_command_is_found(line: str, said: str) -> None:
    """For what is wrong about it; the type of the error is that of the check."""
    words = line.split()
    with pytest.raises(Exception, match=re.escape(said)):
        CHECKS[words[0]](words[1:], True)
