"""What is told about the cost of a drive is what the target counts."""

import re
from pathlib import Path

import pytest

from sensorless.export.export import Exported
from sensorless.pil.pil import Report
from tests.helpers.documentation import ROOT

SLACK = 1.1
"""Most that a bound in words may lie above what is counted."""


def test_the_readme_of_an_export_has_the_bytes(report: Report, exported: Exported) -> None:
    """Both are of the same table on the same machine."""
    page = " ".join((exported.folder / "README.md").read_text(encoding="utf-8").split())
    told = re.search(r"takes (\d+) bytes of RAM, .* (\d+) bytes of flash \((\d+) in 16", page)
    assert told is not None
    memory = report["memory"]
    counted = [report["ram_state"], *(memory[f"table_{n}"]["rodata"] for n in ("f32", "q15"))]
    assert list(map(int, told.groups())) == counted


@pytest.mark.parametrize("name", ["README.md", "docs/index.md"])
def test_the_first_pages_have_its_bounds(name: str, report: Report) -> None:
    """Of the period with its decision, and of the state; a schedule changes them a little."""
    page = (Path(ROOT) / name).read_text(encoding="utf-8")
    for pattern, counted in (
        (r"[Aa]t most (\d+) instructions", report["instructions"]["period"]["max"]),
        (r"at most (\d+) bytes of RAM", report["ram_state"]),
    ):
        (bound,) = set(re.findall(pattern, " ".join(page.split())))
        assert counted <= int(bound) <= SLACK * counted, pattern
