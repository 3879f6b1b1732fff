"""Progress where no terminal shows a bar."""

import time

import pytest

from sensorless.cli import options


def test_a_line_a_minute(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    now = [0.0]
    monkeypatch.setattr(time, "monotonic", lambda: now[0])
    say = options.minutely()
    for now[0] in (1.0, 59.0, 60.5, 61.0, 119.0, 121.0):
        say(f"at {now[0]:g} s")
    assert capsys.readouterr().err == "at 60.5 s\nat 121 s\n"
