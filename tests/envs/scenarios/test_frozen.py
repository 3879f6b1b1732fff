"""Frozen suites are what they were."""

import dataclasses

import numpy as np
import pytest

from sensorless.envs.scenarios.frozen import FROZEN, MOTOR, Frozen, digest
from sensorless.machine.motor import Motor

PAPER = Motor.load(MOTOR)


@pytest.mark.parametrize("frozen", FROZEN, ids=lambda frozen: frozen.suite)
def test_the_scenarios_have_not_changed(frozen: Frozen) -> None:
    assert digest(frozen.rows(PAPER).draw()) == frozen.digest


def test_the_digest_sees_every_field_but_not_the_last_bit_of_a_double() -> None:
    drawn = FROZEN[0].rows(PAPER)[:3].draw()
    was = digest(drawn)
    for field in dataclasses.fields(drawn):
        x = getattr(drawn, field.name)
        near = np.nextafter(x, np.inf) if x.dtype.kind == "f" else x
        assert digest(dataclasses.replace(drawn, **{field.name: near})) == was, field.name
        far = x.copy()
        far.flat[-1] = far.flat[-1] ^ x.dtype.type(1) if x.dtype.kind in "bu" else 3.25
        assert digest(dataclasses.replace(drawn, **{field.name: far})) != was, field.name
