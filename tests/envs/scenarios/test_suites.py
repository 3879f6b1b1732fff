"""Suites: any part of one is what it is in the whole."""

from dataclasses import fields

import numpy as np
import pytest

from sensorless.envs.scenarios.suites import SUITES, SuiteRows, suite
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

MOTOR = Motor.load("paper")


@pytest.mark.parametrize("name", SUITES)
def test_a_part_drawn_alone_is_that_part_of_the_whole(name: str) -> None:
    whole, rows = suite(name, MOTOR, 5, 121), SuiteRows(name, MOTOR, 5, 121)
    assert len(rows) == len(whole) == 121
    for part in (slice(0, 1), slice(17, 60), slice(60, 200)):
        drawn, wanted = rows[part].draw(), whole[part]
        assert len(rows[part]) == len(drawn)
        assert rows[part].seed.tolist() == drawn.seed.tolist()
        for f in fields(whole):
            a, b = getattr(drawn, f.name), getattr(wanted, f.name)
            assert a.dtype == b.dtype and a.tobytes() == np.ascontiguousarray(b).tobytes(), f.name


def test_a_part_of_a_part() -> None:
    rows = SuiteRows("handoff", MOTOR, 5, 121)
    assert rows[10:50][5:7] == SuiteRows("handoff", MOTOR, 5, 121, rows=range(15, 17))


@pytest.mark.parametrize(
    ("name", "seed", "size", "role", "said"),
    [
        ("nobody", 1, 9, "test", "suite"),
        ("stress", 1, 9, "play", "role"),
        ("stress", -1, 9, "test", "seed"),
        ("stress", 1, 0, "test", "size"),
        ("envelope", 1, 10, "test", "square"),
    ],
)
def test_what_is_no_suite(name: str, seed: int, size: int, role: str, said: str) -> None:
    with pytest.raises(UserError, match=said):
        SuiteRows(name, MOTOR, seed, size, role)
