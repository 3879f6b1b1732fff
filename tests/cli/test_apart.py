"""No command writes over a file that it also reads or writes."""

import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

from sensorless.cli.apart import WRITTEN
from sensorless.cli.app import app
from sensorless.machine.motor import MOTORS
from tests.helpers.command import run


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("motor check m.toml --out m.toml", "out: 'm.toml' is also the file of FILE"),
        ("simulate --motor m.toml --out ./m.toml", "file of --motor"),
        ("simulate --motor link.toml --plot m.toml", "plot: 'm.toml' is also the file of --motor"),
        ("simulate --set cross=x --out x", "file of --set"),
        ("simulate --scenario x:0:min --out x", "file of --scenario"),
        ("simulate --log a.csv --out a.csv", "log: 'a.csv' is also the file of --out"),
        ("simulate --plot a.csv --out a.csv", "plot: 'a.csv' is also the file of --out"),
        ("evaluate --policy eq25 --policy tuned:x --out x", "file of --policy"),
        ("replay x --out x", "file of LOG.csv"),
        ("replay x --map m.toml --out m.toml", "file of --map"),
        ("identify machine --log x --save-log x", "save-log: 'x' is also the file of --log"),
        ("motor import-map x --motor paper --out x", "file of FILE"),
        ("tune linear --motor m.toml --out m.toml", "file of --motor"),
        ("export x --out x", "file of SCHEDULE"),
        ("report x --out x", "file of POLICY"),
        ("certify x --out x", "file of POLICY"),
    ],
)
def test_a_file_is_not_written_over(words: str, said: str, tmp_path: Path) -> None:
    shutil.copy(MOTORS / "paper.toml", tmp_path / "m.toml")
    (tmp_path / "link.toml").symlink_to("m.toml")
    (tmp_path / "x").write_text("kept")
    done = run(*words.split(), cwd=tmp_path)
    assert done.returncode == 2 and said in done.stderr
    assert (tmp_path / "x").read_text() == "kept"
    assert (tmp_path / "m.toml").read_bytes() == (MOTORS / "paper.toml").read_bytes()
    assert {path.name for path in tmp_path.iterdir()} == {"m.toml", "link.toml", "x"}


@pytest.mark.parametrize(
    "words",
    [
        "motor new --name a --out m.toml",
        "motor import-map x --motor paper --out m.toml",
        "identify machine --out m.toml",
        "evaluate --policy eq25 --out m.toml",
        "simulate --plot link.toml",
        "simulate --out link.csv",
    ],
)
def test_a_motor_file_is_replaced_only_if_asked(words: str, tmp_path: Path) -> None:
    """Before the first question, too: there is nobody to answer it."""
    (tmp_path / "m.toml").write_text("by hand")
    (tmp_path / "link.toml").symlink_to("m.toml")
    (tmp_path / "link.csv").symlink_to("m.toml")
    (tmp_path / "x").touch()
    done = run(*words.split(), cwd=tmp_path)
    option, file = words.split()[-2:]
    more = ", or add --replace" if words.startswith(("motor", "identify")) else ""
    assert done.returncode == 2 and not done.stdout
    assert done.stderr == f"error: {option[2:]}: '{file}' exists; write to another file{more}\n"
    assert (tmp_path / "m.toml").read_text() == "by hand"


def test_devices_may_be_given_twice(tmp_path: Path) -> None:
    words = "simulate --duration 0.01 --out /dev/null --log /dev/null --quiet"
    assert run(*words.split(), cwd=tmp_path).returncode == 0


def test_a_demo_does_not_empty_the_folder_of_its_motor(tmp_path: Path) -> None:
    folder = tmp_path / "demo"
    folder.mkdir()
    (folder / ".sensorless-demo").touch()
    shutil.copy(MOTORS / "paper.toml", folder / "m.toml")
    done = run("demo", "--motor", "demo/m.toml", "--out", "demo", cwd=tmp_path)
    assert done.returncode == 2 and "holds the file of --motor" in done.stderr
    assert (folder / "m.toml").is_file()


def written(command: Any) -> Iterator[str]:
    """Parameters of a command, or of all in a group, that name what to write."""
    for inner in getattr(command, "commands", {}).values():
        yield from written(inner)
    for param in command.params:
        if (getattr(param, "help", None) or "").startswith("Write "):
            yield param.name


def test_every_option_that_writes_is_known() -> None:
    """``name`` is a folder below runs/, which has to be new."""
    found = set(written(typer.main.get_command(app)))
    assert found <= {*WRITTEN, "name"} and len(found) > 2
