"""Fingerprints of a drive's numbers."""

import pytest

from sensorless.design import control, fingerprint
from sensorless.design.drive import DriveDesign
from sensorless.design.records import designed
from sensorless.machine.motor import Motor


def test_a_later_number_counts_where_it_is_not_zero(
    motor: Motor, monkeypatch: pytest.MonkeyPatch
) -> None:
    def control_part() -> str:
        designed.cache_clear()
        return fingerprint.fingerprint(motor, DriveDesign())["control"]

    without = control_part()
    monkeypatch.setattr(control, "reference_share", lambda motor: 0.5)
    assert control_part() != without
    monkeypatch.undo()
    monkeypatch.setattr(fingerprint, "LATER", frozenset())
    assert control_part() != without, "as a field that older files do not know"
    monkeypatch.undo()
    assert control_part() == without
