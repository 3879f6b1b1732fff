"""Talking to a program: answers that come in pieces, and programs that do not answer."""

import sys

import numpy as np
import pytest

from sensorless.errors import UserError
from sensorless.pil import device as module
from sensorless.pil.device import ANSWERS, Device, Operation

PIECES = """
import struct, sys, time
operation, n = struct.unpack("<II", sys.stdin.buffer.read(8))
answer = struct.pack("<6I", operation, n, 3, 4, 5, 6)
for part in (answer[:5], answer[5:]):
    sys.stdout.buffer.write(part)
    sys.stdout.buffer.flush()
    time.sleep(0.05)
sys.stdin.buffer.read(8)
"""


def program(text: str) -> list[str]:
    return [sys.executable, "-S", "-E", "-c", text]


def test_an_answer_in_pieces_is_put_together() -> None:
    with Device(program(PIECES)) as device:
        (found,) = device.ask(Operation.INFO)
    names = ANSWERS[Operation.INFO].names or ()
    assert [int(found[name]) for name in names] == [int(Operation.INFO), 0, 3, 4, 5, 6]


def test_a_program_that_stops_says_so_with_its_last_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PATIENCE", 1.5)
    stops = "import sys; sys.stdin.buffer.read(8); sys.stderr.write('one\\nboom\\n'); sys.exit(3)"
    with (
        pytest.raises(UserError, match=r"stopped early with status 3 \(boom\)"),
        Device(program(stops)) as device,
    ):
        device.ask(Operation.INFO)


def test_a_program_that_is_silent_is_not_waited_for(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "PATIENCE", 0.2)
    with (
        pytest.raises(UserError, match=r"did not answer within 0\.2 s"),
        Device(program("import time; time.sleep(9)")) as device,
    ):
        device.send(Operation.STEP, np.zeros(1, dtype=module.DRIVE_IN))
        device.receive(Operation.STEP, 1)
