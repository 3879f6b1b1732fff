"""The entry point: what goes wrong is one line, never a traceback."""

import sys
from types import ModuleType

import pytest

from sensorless.cli.main import main
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
