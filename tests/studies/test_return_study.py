"""Returns at a small size: those of two intervals agree, and the record holds every rule."""

import json
import sys
from pathlib import Path

import pytest

from tests.helpers.script import script


def test_what_an_episode_earns(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module, out = script("studies/return_study.py"), tmp_path / "returns.json"
    monkeypatch.setattr(sys, "argv", ["return_study", "--size", "16", "--out", str(out)])
    module.main()
    record = json.loads(out.read_text())
    assert set(record["policies"]) == set(module.POLICIES) and record["size"] == 16
    assert record["policies"]["logistic-tuned"]["1 ms"]["lost"] == 0
    for found in record["policies"].values():
        assert -60.0 < found["5 ms"]["return"] < -1.0
        assert found["5 ms"]["return"] == pytest.approx(found["1 ms"]["return"], rel=0.05)
        assert found["5 ms"]["worst"] <= found["5 ms"]["return"]
        assert 0.0 < found["torque_ripple_rms"] < found["torque_dev_rms"] < 0.2
