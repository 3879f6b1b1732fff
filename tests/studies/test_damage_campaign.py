"""The damage campaign: one word of a running drive's state at a time."""

from types import ModuleType

import numpy as np
import pytest

from sensorless.machine.motor import Motor
from tests.helpers.script import script


@pytest.fixture(scope="module")
def study() -> ModuleType:
    return script("studies/damage_campaign.py")


def test_each_case_damages_one_word(study: ModuleType, motor: Motor) -> None:
    sims, _ = study.running(motor, "coupled")
    cases = study.damaged(sims[:2])
    kinds = [kind for _, kind in study.words()]
    assert cases.shape == (len(kinds), len(study.VALUES) + len(study.FLIPS), 2)
    before = np.ascontiguousarray(sims[:2]["drive"]["x"]).view(np.uint32).reshape(2, -1)
    after = np.ascontiguousarray(cases["drive"]["x"]).view(np.uint32)
    changed = after.reshape(*cases.shape, -1) != before
    own = np.eye(len(kinds), dtype=bool)[:, None, None]
    assert not (changed & ~own).any()
    assert changed.any(axis=-1)[:, len(study.VALUES) :].all()
    floats = np.array(kinds) == "f"
    assert changed.any(axis=-1)[floats, 0].all() and not changed[~floats, 0].any()


def test_no_damage_reaches_the_voltage_and_hardly_any_goes_astray_in_silence(
    study: ModuleType, motor: Motor
) -> None:
    """Before finite words were checked, 96 of 13,420 went astray without a bit."""
    found = study.run(motor, "coupled")
    assert not found["infinite"].any()
    assert (found["astray"] & ~found["flagged"]).sum() <= 8
    not_numbers = found["flagged"][:, 0]
    names = [name for name, _ in study.words()]
    for name in ("control.i_int", "emf.pll.theta", "coupled.psi.a"):
        assert not_numbers[names.index(name)].all()


def test_a_drive_without_damage_is_neither_flagged_nor_astray(
    study: ModuleType, motor: Motor, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(study, "VALUES", ())
    monkeypatch.setattr(study, "FLIPS", (0,))  # the last digit of a float
    found = study.run(motor, "coupled")
    ends = ("k_s", "coupled.drift.trust")  # 1 is the end of their range: above it is damage
    rows = [j for j, (name, kind) in enumerate(study.words()) if kind == "f" and name not in ends]
    assert not found["flagged"][rows].any() and not found["astray"][rows].any()
