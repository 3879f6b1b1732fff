"""What the tests of the source paper's claims share."""

import pytest

from sensorless.machine.motor import Motor


@pytest.fixture(scope="session")
def motor() -> Motor:
    return Motor.load("paper")
