"""Conversions of units have one home."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from sensorless.units import RAD_S_TO_RPM, RPM_TO_RAD_S, rad_per_s, wrapped

ROOT = Path(__file__).parents[1]
CODE = tuple(
    "agents baselines benchmarks core docs envs examples observers sensorless studies web".split()
)
WRAP = re.compile(r"remainder\([^()]*\+ (?:np|math)\.pi, 2")
BY_HAND = re.compile(
    r"\b(?:pi|PI)\s*/\s*30\b|\b30(?:\.0?)?\s*/\s*(?:\w+\.)?pi\b|9\.549\d*|0\.10471\d*"
)


def test_a_turn_a_second() -> None:
    assert rad_per_s(60.0) == pytest.approx(2.0 * math.pi, rel=1e-15)
    assert RPM_TO_RAD_S * 60.0 == pytest.approx(2.0 * math.pi, rel=1e-15)
    assert RAD_S_TO_RPM * RPM_TO_RAD_S == pytest.approx(1.0, rel=1e-15)


@pytest.mark.parametrize("text", ["n * np.pi / 30.0", "30.0 / math.pi", "Math.PI / 30", "9.5493"])
def test_a_conversion_by_hand_is_found(text: str) -> None:
    assert BY_HAND.search(text)


def test_nobody_else_converts_speeds() -> None:
    files = [p for name in CODE for end in ("py", "js") for p in (ROOT / name).rglob(f"*.{end}")]
    assert len(files) > 100
    by_hand = {
        path.relative_to(ROOT)
        for path in files
        if path.name != "units.py" and BY_HAND.search(path.read_text(encoding="utf-8"))
    }
    assert not by_hand, "take them from sensorless/units.py"


def test_an_angle_is_wrapped() -> None:
    """To the half-open turn around 0, whatever its shape."""
    angles = np.array([[0.0, math.pi], [-math.pi, 7.0]])
    assert wrapped(angles) == pytest.approx(np.array([[0.0, -math.pi], [-math.pi, 7.0 - math.tau]]))
    assert wrapped(-4.0) == pytest.approx(math.tau - 4.0)


def test_nobody_else_wraps_angles() -> None:
    code = [p for name in CODE for p in (ROOT / name).rglob("*.py") if p.name != "units.py"]
    assert not [p for p in code if WRAP.search(p.read_text(encoding="utf-8"))], "take wrapped()"
