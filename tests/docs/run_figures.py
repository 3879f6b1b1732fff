"""Every picture of the theory pages is drawn by its command: ``make docs-test``."""

from pathlib import Path

import pytest

from docs.site import figures
from sensorless.plots.figure import png

ROOT = Path(__file__).parents[2]


@pytest.mark.parametrize("name", figures.FIGURES)
def test_a_picture_is_drawn_from_a_few_points(name: str) -> None:
    assert png(figures.FIGURES[name](4)).startswith(b"\x89PNG")
    assert (ROOT / "docs" / f"{name}.png").is_file()
