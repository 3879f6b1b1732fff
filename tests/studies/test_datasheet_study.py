"""The study of published numbers makes a file of each machine, and counts what is lost."""

import json
import sys
from pathlib import Path

import pytest

from tests.helpers.script import script


def test_every_sheet_is_judged_or_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module, out = script("studies/datasheet_study.py"), tmp_path / "sheets.json"
    monkeypatch.setattr(sys, "argv", ["datasheet_study", "--size", "4", "--out", str(out)])
    module.main()
    record = json.loads(out.read_text())
    assert {name for name, lost in record["lost"].items() if lost is None} == {"stepper", "servo"}
    assert len(record["lost"]) == 14 and record["lost"]["ebike_hub"] == {"nominal": 0, "stress": 0}


def test_the_page_has_what_the_record_counts() -> None:
    root = Path(__file__).resolve().parents[2]
    page = (root / "docs" / "motor-check.md").read_text(encoding="utf-8")
    found = json.loads((root / "results" / "studies" / "datasheets.json").read_text())
    for name, lost in found["lost"].items():
        rows = [[cell.strip() for cell in line.split("|")] for line in page.splitlines()]
        (row,) = (r for r in rows if len(r) == 8 and r[1].startswith(f"`{name}`"))
        cells = row[5:7]
        assert cells == (["–", "–"] if lost is None else [str(n) for n in lost.values()]), name
