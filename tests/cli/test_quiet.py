"""``--json`` is all that a program reads, and ``--quiet`` leaves the result alone."""

import json
from pathlib import Path

import pytest
import typer
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.cli.options import console, errors
from sensorless.errors import UserError


def commands(group: typer.core.TyperGroup, before: str = "") -> dict[str, set[str]]:
    """Options of every command by its words."""
    out: dict[str, set[str]] = {}
    for name, command in group.commands.items():
        if isinstance(command, typer.core.TyperGroup):
            out |= commands(command, f"{before}{name} ")
        else:
            out[before + name] = {word for p in command.params for word in p.opts}
    return out


def test_every_command_has_both() -> None:
    group = typer.main.get_command(app)
    assert isinstance(group, typer.core.TyperGroup)
    found = commands(group)
    assert len(found) > 15
    assert [name for name, options in found.items() if "--quiet" not in options] == []
    assert [name for name, options in found.items() if "--json" not in options] == []


@pytest.mark.usefixtures("without_ekf")
@pytest.mark.parametrize(
    ("words", "key"),
    [
        ("simulate --duration 0.02", "plateaus"),
        ("certify eq25 --size 8", "lost"),
        ("evaluate --policy eq25 --size 2", "policies"),
        ("replay sample", "estimators"),
        ("motors", "paper"),
        ("motor check paper --size 0", "verdict"),
        ("identify bring-up --mistake delay-2", "said"),
        ("identify bring-up --size 2", "pole_pairs"),
    ],
)
def test_json_is_all_that_is_printed(words: str, key: str, tmp_path: Path) -> None:
    done = CliRunner().invoke(app, [*words.split(), "--json"])
    assert key in json.loads(done.stdout)


def test_quiet_names_no_files_and_still_gives_the_result(tmp_path: Path) -> None:
    words = ["simulate", "--duration", "0.02", "--out", str(tmp_path / "run.csv")]
    loud = CliRunner().invoke(app, words)
    quiet = CliRunner().invoke(app, [*words, "--quiet"])
    assert "run.csv" in loud.stderr and quiet.stderr == ""
    assert quiet.stdout == loud.stdout


def test_the_consoles_speak_again_after_an_error() -> None:
    done = CliRunner().invoke(app, ["simulate", "--quiet", "--json", "--policy", "nobody"])
    assert isinstance(done.exception, UserError)
    assert not console.quiet and not errors.quiet
