"""A machine changed in Python is checked as one from a file is."""

from dataclasses import fields, replace
from typing import Any

import gymnasium
import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import evaluate
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy

MOTOR = Motor.load("paper")


NUMBERS = {f.name: getattr(MOTOR, f.name) for f in fields(Motor)} | {"speed_hz": 2.5}
NUMBERS = {name: old for name, old in NUMBERS.items() if type(old) in (int, float)}


def test_all_but_words_and_flux_are_numbers() -> None:
    others = {"name", "description", "pole_at_rest", "saturation", "flux_correction"}
    assert {f.name for f in fields(Motor)} - set(NUMBERS) == others


@pytest.mark.parametrize(("name", "old"), NUMBERS.items(), ids=NUMBERS)
def test_numbers_of_numpy_are_numbers(name: str, old: float) -> None:
    new: Any = np.int64(old) if isinstance(old, int) else np.float32(old)
    changed = replace(MOTOR, **{name: new})
    assert type(getattr(changed, name)) is type(old)
    assert getattr(changed, name) == pytest.approx(old, rel=1e-7)
    env = gymnasium.make("sensorless/Blend-v0", motor=changed)
    assert np.isfinite(env.reset(seed=1)[0]).all()


@pytest.mark.parametrize("name", ["B", "J", "winding_per_K", "R_s", "n_p", "T_s"])
@pytest.mark.parametrize("bad", [float("nan"), float("inf"), "x", None, True])
def test_what_is_no_number_is_named(name: str, bad: object) -> None:
    with pytest.raises(UserError, match=rf"^motor 'paper': {name}: .*(must be|give)"):
        replace(MOTOR, **{name: bad})  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "bad"),
    [("R_s", -1.0), ("B", -1.0), ("J", -0.02), ("n_p", 0), ("adc_bits", 0), ("T_s", 1.0),
     ("T_s", 0.0), ("p_iron", -5.0), ("psi_f", 0.0), ("winding_per_K", 1.0)],
)  # fmt: skip
def test_what_is_out_of_range_is_named(name: str, bad: float) -> None:
    change: dict[str, Any] = {name: bad}
    motor = replace(MOTOR, **change)
    with pytest.raises(UserError, match=f"^motor 'paper': {name} = {bad:g}: must be"):
        evaluate(motor, DriveDesign(), "stress-1", 7, 2, {"eq25": make_policy("eq25", MOTOR)})
    with pytest.raises(UserError, match=f"^motor 'paper': {name} = {bad:g}: must be"):
        gymnasium.make("sensorless/Blend-v0", motor=motor).reset(seed=1)
