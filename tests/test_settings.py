"""Settings: what one declaration gives, and how a wrong value is told."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.settings import (
    REQUIRED,
    Setting,
    check,
    derived,
    number,
    read,
    settings_of,
    switch,
    word,
)


@dataclass(frozen=True)
class Pump:
    """One setting of every kind, and a field that is none."""

    head: float = number(REQUIRED, "m", 0, 50, "height it lifts to", above=True)
    stages: int = number(REQUIRED, "1", 1, 9, "wheels in a row")
    flow: float = number(2.0, "l/s", 0.5, math.inf, "water it moves")
    valve: float = number(math.inf, "s", 0.1, math.inf, "time to close; inf: never", endless=True)
    dry: bool = switch(False, "may run without water")
    seal: str = word(
        "lip",
        "what keeps the shaft tight",
        {"lip": "rubber", "face": "ceramic", "FILE.json": "as measured"},
        renamed={"gland": "lip"},
        was="gasket",
    )
    label: str = word("pump", "name on the plate")
    age: int = 0


KNOWN = settings_of(Pump)
GOOD = {"head": 10.0, "stages": 2}


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("head", 0.0, "head: 0.0: must be above 0 and at most 50 m (height it lifts to)"),
        ("head", 51, "head: 51: must be above 0 and at most 50 m"),
        ("head", "10", "head: '10': must be a number above 0 and at most 50 m"),
        ("head", True, "head: True: must be a number above 0"),
        ("head", 10**400, "head: 1000000"),
        ("stages", 2.0, "stages: 2.0: must be a whole number between 1 and 9 (wheels in a row)"),
        ("stages", 10, "stages: 10: must be a whole number between 1 and 9"),
        ("flow", math.nan, "flow: nan: must be a finite number at least 0.5 l/s"),
        ("flow", math.inf, "flow: inf: must be a finite number at least 0.5 l/s"),
        ("valve", 0.0, "valve: 0.0: must be at least 0.1 s, or inf (time to close; inf: never)"),
        ("valve", math.nan, "valve: nan: must be at least 0.1 s, or inf"),
        ("dry", 1, "dry: 1: must be true or false (may run without water)"),
        ("seal", "cork", "seal: 'cork': must be lip, face or FILE.json (what keeps the shaft"),
        ("seal", "gland", "seal: 'gland' is now called 'lip': write lip"),
        ("seal", None, "seal: None: must be lip, face or FILE.json"),
        ("label", 3, "label: 3: must be text (name on the plate)"),
    ],
)
def test_a_wrong_value_is_told(name: str, value: object, said: str) -> None:
    """Also by the check of an instance, behind the word that says where."""
    assert not KNOWN[name].holds(value)
    with pytest.raises(UserError) as caught:
        KNOWN[name].checked(value)
    assert str(caught.value).startswith(said)
    values: dict[str, Any] = {**GOOD, name: value}
    with pytest.raises(UserError) as caught:
        check(Pump(**values), "pump.toml: ")
    assert str(caught.value).startswith("pump.toml: " + said)


@pytest.mark.parametrize(
    ("name", "text", "value"),
    [
        ("head", "1e1", 10.0),
        ("stages", "9", 9),
        ("valve", "inf", math.inf),
        ("dry", "true", True),
        ("seal", "worn.json", "worn.json"),
        ("label", "", ""),
    ],
)
def test_a_text_becomes_a_value(name: str, text: str, value: object) -> None:
    found = KNOWN[name].parsed(text)
    assert found == value and type(found) is type(value)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("head", "ten", "must be a number above 0"),
        ("stages", "2.5", "must be a whole number"),
        ("dry", "yes", "must be true or false"),
    ],
)
def test_a_text_that_is_no_value_is_told(name: str, text: str, said: str) -> None:
    with pytest.raises(UserError, match=f"^{name}: '{text}': {said}"):
        KNOWN[name].parsed(text)


def test_numbers_of_numpy_are_numbers() -> None:
    assert KNOWN["flow"].checked(np.float32(1.5)) == 1.5
    assert KNOWN["stages"].checked(np.int64(3)) == 3
    assert type(KNOWN["stages"].checked(np.int64(3))) is int


def test_fields_declared_otherwise_are_no_settings() -> None:
    assert "age" not in KNOWN
    assert [s.kind for s in KNOWN.values()] == [float, int, float, float, bool, str, str]


def test_a_table_is_read_whole() -> None:
    """Numbers of their kind; what is unknown or missing is named."""
    found = read(Pump, {"head": 3, "stages": 1}, "pump.toml: ")
    assert found == {"head": 3.0, "stages": 1} and type(found["head"]) is float
    with pytest.raises(UserError, match=r"pump.toml: colour: unknown: use only head, stages"):
        read(Pump, {**GOOD, "colour": 3}, "pump.toml: ")
    with pytest.raises(UserError, match=r"toml: gasket: is now seal: write seal, lip, face or"):
        read(Pump, {**GOOD, "gasket": True}, "pump.toml: ")
    with pytest.raises(UserError, match=r"^stages: missing: give wheels in a row, between 1 and 9"):
        read(Pump, {"head": 3.0}, "")


def test_the_sentence_of_a_help_text() -> None:
    assert KNOWN["head"].sentence == "Height it lifts to (above 0 and at most 50 m)."
    assert KNOWN["dry"].sentence == "May run without water."
    assert KNOWN["seal"].sentence == (
        "What keeps the shaft tight; lip: rubber; face: ceramic; FILE.json: as measured."
    )


def test_settings_can_be_keys() -> None:
    assert len({*KNOWN.values(), Setting("head", 1.0, "m", 0.0, 1.0, "")}) == 8


@dataclass(frozen=True)
class Tank:
    """A setting that follows from others unless it is given."""

    level: float | None = derived("m", 0, 3, "height of the water")


def test_auto_leaves_a_number_to_its_formula() -> None:
    """In a file as in a word; but code says None."""
    assert read(Tank, {"level": "auto"}, "") == {"level": None}
    assert settings_of(Tank)["level"].parsed("auto") is None
    with pytest.raises(UserError, match="between 0 and 3 m, or auto"):
        check(Tank(level="auto"))  # type: ignore[arg-type]


def test_numbers_of_numpy_become_numbers_of_python() -> None:
    """JSON writes no others: a tuning would end without its file."""
    design = DriveDesign(smo_gain=np.float32(1.0))  # type: ignore[arg-type]
    assert type(design.smo_gain) is float
