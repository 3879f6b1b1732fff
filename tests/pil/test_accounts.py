"""The report of a processor in the loop, from a target whose every answer is set here."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sensorless.core.api import Array
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.machine.motor import Motor
from sensorless.pil import pil as module
from sensorless.pil.device import ANSWERS, Operation
from sensorless.pil.pil import Report, passed, pil
from sensorless.table.image import lookup
from sensorless.table.ks_table import Axis, KsTable

TABLE = KsTable((Axis("speed", 0.1, 0.5, 3),), np.array([1.0, 0.4, 0.0], dtype=np.float32))
SIZES = {"drive.o": {"text": 700, "bss": 4}, "ks_table.o": {"text": 50},
         "table_f32": {"rodata": 30}, "table_q15": {"rodata": 20}, "table_check": {"text": 9},
         "image": {"text": 99999}}  # fmt: skip


class Target:
    """Two ticks an instruction, 20 of the measurement; one Q15 and two float lookups are wrong."""

    def __init__(self, *_: object) -> None:
        pass

    def __enter__(self) -> "Target":
        return self

    def __exit__(self, *_: object) -> None:
        pass

    def ask(self, operation: Operation, items: Array | None = None) -> Array:
        out = np.zeros(1 if items is None else len(items), dtype=ANSWERS[operation])
        if operation == Operation.INFO:
            out["ticks_0"], out["ticks_1000"], out["ticks_call"] = 20, 20 + 2 * 1002, 20 + 2 * 12
            out["drive_state"], out["schedule_state"], out["drive_params"] = 600, 24, 400
        elif operation == Operation.TESTS:
            out[out.dtype.names[-1]] = 1
        elif operation == Operation.LOOKUP:
            assert items is not None
            for form in ("f32", "q15"):
                k_s = lookup(TABLE.record(form).reshape(1), TABLE.stored(form), items)
                out[f"k_s_{form}"] = k_s
                out[f"ticks_{form}"] = 20 + 2 * 60
            if not hasattr(self, "asked"):
                out["k_s_q15"][0] += 1.0
                out["k_s_f32"][:2] += 1.0
                out["ticks_q15"][0] = 20 + 2 * 80
            self.asked = True
        else:
            for j, name in enumerate(out.dtype.names or ()):
                out[name] = 20 + 2 * (100 * j + np.arange(len(out)))
        return out


@pytest.fixture
def report(monkeypatch: pytest.MonkeyPatch) -> Report:
    run = SimpleNamespace(
        periods=np.array([3, 4]), mismatches=np.array([0, 2]), first=(1, 0, 5),
        lost=np.zeros(2, np.int32), ticks=np.array([[40, 30], [60, 50]], np.uint32),
        k_s=np.array([[0.0, 1.0], [0.25, 0.5]]),
    )  # fmt: skip
    given: dict[str, Any] = {
        "require_tools": None, "export": None, "build": Path("image.elf"), "lockstep": run,
        "memory": SIZES, "stack_of": 77, "fused_instructions": 0, "versions": {},
        "pil_scenarios": (("one", "two"), [0, 1]),
    }  # fmt: skip
    for name, answer in given.items():
        monkeypatch.setattr(module, name, lambda *_, answer=answer, **__: answer)
    monkeypatch.setattr(module, "Device", Target)
    monkeypatch.setattr(SimFactory, "build", lambda *_: None)
    return pil(TABLE, Motor.load("paper"), DriveDesign())


def test_what_differs_is_counted(report: Report) -> None:
    assert (report["periods"], report["mismatches"], report["first_mismatch"]) == (7, 2, (1, 0, 5))
    assert report["lookups"] == 2 * 1024 and report["lookup_mismatches"] == 3
    assert not passed(report)
    assert sum(report["target_tests"].values()) == 1
    second = {"name": "two", "periods": 4, "mismatches": 2, "lost": None, "k_s": [0.25, 0.5]}
    assert report["scenarios"][1] == second


def test_instructions_are_without_those_of_the_call(report: Report) -> None:
    """Of its 12, two are inside the function that is called."""
    count = report["instructions"]
    assert count["period"] == {"min": 10.0, "mean": 15.0, "max": 20.0}
    assert count["drive_step"] == {"min": 5.0, "mean": 10.0, "max": 15.0}
    assert count["lookup_f32"] == {"min": 50.0, "mean": 50.0, "max": 50.0}
    assert (count["lookup_q15"]["min"], count["lookup_q15"]["max"]) == (50.0, 70.0)
    parts = [spread for name, spread in count.items() if name.startswith("part_")]
    assert parts[1] == {"min": 100.0, "mean": 100.5, "max": 101.0}


def test_flash_and_ram(report: Report) -> None:
    """Objects, parameters and the float table; both states."""
    assert report["flash_core"] == (700 + 4) + 50 + 400 + 30
    assert report["flash_table_and_check"] == 39
    assert report["ram_state"] == 624 and report["stack"] == 77
