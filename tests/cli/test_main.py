"""The entry point: what goes wrong is one line, never a traceback."""

import os
import signal
import sys
import time
from types import ModuleType

import pytest
import typer

from sensorless.cli.main import NO_MEMORY, main
from sensorless.errors import StaleCoreError, UserError


class Raising(ModuleType):
    """A command line that fails while it is imported."""

    def __init__(self, error: BaseException) -> None:
        super().__init__("sensorless.cli.app")
        self._error = error

    def __getattr__(self, name: str) -> object:
        if name == "app":
            raise self._error
        raise AttributeError(name)


@pytest.mark.parametrize(
    ("error", "status", "said"),
    [
        (StaleCoreError("run 'make core'"), 2, "error: run 'make core'\n"),
        (UserError("size: 0 [1]; give at least 1"), 2, "error: size: 0 [1]; give at least 1\n"),
        (KeyboardInterrupt(), 130, "interrupted\n"),
        (
            OSError(28, "No space left on device"),
            2,
            "error: No space left on device; free or change what it names, then rerun the "
            "command\n",
        ),
        (
            MemoryError(),
            2,
            f"error: {NO_MEMORY}\n",
        ),
        (
            ImportError("libtorch_cpu.so: failed to map segment from shared object"),
            2,
            f"error: {NO_MEMORY}\n",
        ),
    ],
)
def test_one_line_and_a_status(
    error: BaseException,
    status: int,
    said: str,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setitem(sys.modules, "sensorless.cli.app", Raising(error))
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == status
    assert capsys.readouterr().err == said


def test_an_error_of_the_program_is_one_line_that_asks_for_a_report(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "sensorless.cli.app", Raising(ZeroDivisionError("by zero")))
    with pytest.raises(SystemExit) as ended:
        main()
    said = capsys.readouterr().err
    assert ended.value.code == 70 and said.count("\n") == 1
    assert said.startswith("error: ZeroDivisionError in ") and "please report" in said
    monkeypatch.setenv("SENSORLESS_TRACEBACK", "1")
    with pytest.raises(ZeroDivisionError):
        main()


def test_ctrl_c_in_a_command_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Typer turns it into an exit of its own; a command that has said it is not repeated."""
    app = typer.Typer()

    @app.command()
    def stopped(quiet: bool = False) -> None:
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt:
            if quiet:
                raise typer.Exit(130) from None
            raise

    module = ModuleType("sensorless.cli.app")
    module.app = app  # type: ignore[attr-defined]
    monkeypatch.setitem(sys.modules, "sensorless.cli.app", module)
    for words, said in (([], "interrupted\n"), (["--quiet"], "")):
        monkeypatch.setattr(sys, "argv", ["sensorless", *words])
        with pytest.raises(SystemExit) as ended:
            main()
        assert ended.value.code == 130 and capsys.readouterr().err == said


class Killed(ModuleType):
    """A command line to which a signal comes."""

    def __getattr__(self, name: str) -> object:
        if name == "app":
            os.kill(os.getpid(), signal.SIGTERM)
            time.sleep(1.0)
        raise AttributeError(name)


def test_a_signal_ends_the_program_as_ctrl_c_does(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "sensorless.cli.app", Killed("sensorless.cli.app"))
    before = signal.getsignal(signal.SIGTERM)
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 128 + signal.SIGTERM
    assert capsys.readouterr().err == "ended by a signal\n"
    assert signal.getsignal(signal.SIGTERM) == before
