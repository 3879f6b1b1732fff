"""One identification, for all tests of what it measured."""

import pytest

from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.procedure import Identified, identify_machine
from sensorless.identify.machine.simulated import Simulated, real_drive
from sensorless.machine.motor import Motor


@pytest.fixture(scope="session")
def measured() -> tuple[Simulated, Identified]:
    motor = Motor.load("ipmsm_2200w")
    source = Simulated(motor, real_drive(motor, 3))
    return source, identify_machine(source, Nameplate.of(motor))
