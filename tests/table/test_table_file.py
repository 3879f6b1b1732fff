"""The file of a schedule table: every bit restored, every change refused."""

import copy
import json
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sensorless.errors import UserError
from sensorless.table.ks_table import Axis, KsTable


def table() -> KsTable:
    return KsTable((Axis("speed", 0.2, 0.3, 2),), np.array([1.0, 0.0], dtype=np.float32))


def same(a: KsTable, b: KsTable) -> bool:
    return (
        (a.axes, a.slew_per_s, a.fallback, a.rule) == (b.axes, b.slew_per_s, b.fallback, b.rule)
        and a.values.tobytes() == b.values.tobytes()
        and a.digest == b.digest
    )


def test_the_file_restores_every_bit(tmp_path: Path) -> None:
    rng = np.random.default_rng(4)
    values = rng.random((5, 4)).astype(np.float32) ** np.float32(20.0)
    values[0] = 0.0, 1.0, 1e-44, np.nextafter(np.float32(1), np.float32(0))
    axes = (Axis("speed", 0.1, 1.0 / 3.0, 5), Axis("torque_current", -1.5, 1.5, 4))
    t = KsTable(axes, values, slew_per_s=0.1, fallback=0.7, rule=(0.1, 0.3))
    t.save(tmp_path / "t.json", {"policy": "é", "limit": np.inf, "seed": 3})
    read = KsTable.load(tmp_path / "t.json")
    assert same(t, read)
    assert read.provenance == {"policy": "é", "limit": "inf", "seed": 3}
    assert [p.name for p in tmp_path.iterdir()] == ["t.json"]
    assert same(t, pickle.loads(pickle.dumps(t))) and same(t, copy.deepcopy(t))


def edited(path: Path, **changes: Any) -> None:
    data = json.loads(path.read_text()) | changes
    path.write_text(json.dumps({k: v for k, v in data.items() if v is not None}))


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"crc32": "0x00000000"}, "crc32: '0x00000000' is not '0x[0-9a-f]{8}'"),
        ({"values": [0.5, 0.25]}, "crc32: "),
        ({"rule": [0.1, 0.3]}, "crc32: "),
        ({"values": [0.5, float("nan")]}, r"node \[1\]: nan; give 0 to 1"),
        ({"values": [0.5, None]}, r"node \[1\]: nan"),
        ({"values": [0.5, [1.0]]}, "values: "),
        ({"values": "abc"}, "values: "),
        ({"values": [0.5, 10**400]}, "values: int too large"),
        ({"slew_per_s": "50"}, "slew_per_s: '50'"),
        ({"slew_per_s": None}, "slew_per_s: missing"),
        ({"extra": 1}, "extra: unknown field"),
        ({"format": "other"}, "format 'other' is not"),
        ({"axes": 3}, "axes: 3"),
        ({"axes": [3]}, "axes: 3"),
        ({"axes": [{"signal": "speed"}]}, "axes: lo: missing"),
        ({"provenance": 3}, "provenance: 3"),
    ],
)
def test_a_changed_file_is_refused(tmp_path: Path, changes: dict[str, Any], message: str) -> None:
    path = tmp_path / "t.json"
    table().save(path)
    KsTable.load(path)
    edited(path, **changes)
    with pytest.raises(UserError, match=message) as error:
        KsTable.load(path)
    assert str(path) in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize("text", ["", "{", "[]", "\x00", "[" * 100_000])
def test_what_is_no_table_is_refused(tmp_path: Path, text: str) -> None:
    path = tmp_path / "t.json"
    path.write_text(text)
    with pytest.raises(UserError, match=r"t\.json: "):
        KsTable.load(path)
    with pytest.raises(UserError, match="No such file"):
        KsTable.load(tmp_path / "none.json")


def test_a_place_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match=r"file/t\.json'.*; write to another folder"):
        table().save(tmp_path / "file" / "t.json")
