"""One schedule against a rule of each machine's own: rerun, the study goes on where it stopped."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from tests.helpers.script import script


def test_no_machine_is_tuned_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study, out, tuned = script("studies/zero_shot.py"), tmp_path / "machines.json", []

    def tune(*words: object) -> SimpleNamespace:
        tuned.append(words)
        return SimpleNamespace(provenance={"policy": "linear:60,240"})

    def run(machines: int, *policies: str) -> list[dict[str, Any]]:
        words = ["--machines", str(machines), "--size", "4", "--out", str(out), "--policy"]
        monkeypatch.setattr(sys, "argv", ["zero_shot", *words, *policies])
        study.main()
        return list(json.loads(out.read_text())["machines"])

    monkeypatch.setattr(study, "tune", tune)
    (first,) = run(1, "eq25")
    again = run(2, "eq25", "reference")
    assert len(tuned) == 2 and len(again) == 2
    assert again[0]["machine"] == first["machine"] != again[1]["machine"]
    assert [set(row["policies"]) for row in again] == [{"eq25", "reference"}] * 2
    assert again[0]["policies"]["eq25"] == first["policies"]["eq25"]
