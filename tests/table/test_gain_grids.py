"""Gains on the grid of a k_s table: lookup, check, file."""

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.interpolate import RegularGridInterpolator

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES, lib
from sensorless.core.gains import DEFAULT, GAIN_NAMES
from sensorless.errors import UserError
from sensorless.table import gain_image
from sensorless.table.ks_table import Axis, GainGrid, KsTable, ValueFormat

AXES = (
    Axis("speed", 0.05, 0.45, 4),
    Axis("torque_current", -1.5, 1.5, 3),
    Axis("disagreement", -1.0, 1.0, 3),
    Axis("k_s", 0.0, 1.0, 2),
)


def table(n_axes: int = 2, gains: tuple[str, ...] = ("observer", "amplitude")) -> KsTable:
    shape = tuple(axis.n for axis in AXES[:n_axes])
    rng = np.random.default_rng(n_axes)
    grids = tuple(
        GainGrid(name, rng.uniform(-1, 0 if name == "amplitude" else 1, shape).astype(np.float32))
        for name in gains
    )
    return KsTable(AXES[:n_axes], rng.random(shape, dtype=np.float32), gains=grids)


@pytest.mark.parametrize("form", ["f32", "q15"])
@pytest.mark.parametrize("n_axes", [1, 2, 3, 4])
def test_a_lookup_is_multilinear_and_clipped(n_axes: int, form: ValueFormat) -> None:
    t = table(n_axes)
    low, high = (np.array([getattr(a, end) for a in t.axes]) for end in ("lo", "hi"))
    places = np.random.default_rng(2).uniform(low - 0.3, high + 0.3, size=(500, n_axes))
    obs = np.full((500, SIGNAL_N), np.nan, dtype=np.float32)
    obs[:, [SIGNAL_NAMES.index(axis.signal) for axis in t.axes]] = places
    axes = t.record(form).reshape(1)
    header = gain_image.record(t.gains, axes, form, 1e-3)
    found = gain_image.lookup(header, axes, gain_image.stored(t.gains, form), obs)
    nodes = [np.linspace(a.lo, a.hi, a.n) for a in t.axes]
    for j, name in enumerate(GAIN_NAMES):
        grid = next((g for g in t.gains if g.gain == name), None)
        expected = np.zeros(500)
        if grid is not None:
            look = RegularGridInterpolator(nodes, grid.values.astype(np.float64))
            expected = look(np.clip(places, low, high))
        assert np.abs(found[:, j] - expected).max() < (3e-6 if form == "f32" else 4e-5)


@pytest.mark.parametrize("form", ["f32", "q15"])
def test_every_flipped_bit_is_refused(form: ValueFormat) -> None:
    t = table()
    axes, values = t.record(form).reshape(1), gain_image.stored(t.gains, form)
    header = gain_image.record(t.gains, axes, form, 1e-3)
    assert gain_image.check(header, axes, values) == lib.KS_OK
    for image in (header.view(np.uint8), values.view(np.uint8)):
        for j in range(len(image)):
            image[j] ^= np.uint8(1 << j % 8)
            assert gain_image.check(header, axes, values) != lib.KS_OK
            image[j] ^= np.uint8(1 << j % 8)
    assert gain_image.check(header, axes, values) == lib.KS_OK


def test_grids_belong_to_one_table() -> None:
    t = table()
    other = replace(t, fallback=0.5).record().reshape(1)
    header = gain_image.record(t.gains, t.record().reshape(1), "f32", 1e-3)
    found = gain_image.check(header, other, gain_image.stored(t.gains, "f32"))
    assert found == lib.KS_BAD_CRC


def test_a_file_restores_every_bit_and_k_s_alone_keeps_its_format() -> None:
    t = table(3, GAIN_NAMES[:3])
    back = KsTable.from_json(t.to_json(), "here")
    assert back.digest == t.digest
    for a, b in zip(back.gains, t.gains, strict=True):
        assert a.gain == b.gain and a.range == b.range
        np.testing.assert_array_equal(a.values, b.values)
    alone = replace(t, gains=())
    assert json.loads(alone.to_json())["format"] == "sensorless-ks-table/1"
    assert "gains" not in json.loads(alone.to_json())


def test_a_changed_value_in_a_file_is_refused() -> None:
    data = json.loads(table().to_json())
    data["gains"][0]["values"][0][0] = 0.125
    with pytest.raises(UserError, match="crc32"):
        KsTable.from_json(json.dumps(data), "here")


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"gain": "torque"}, "'torque' is not a gain; choose from observer"),
        ({"values": np.full((4, 3), 1.1)}, r"observer \[0, 0\]: 1.1; give -1 to 1"),
        ({"gain": "amplitude", "values": np.full((4, 3), 0.1)}, "give -1 to 0"),
        ({"values": np.zeros((3, 3))}, r"observer: shape \(3, 3\); give \(4, 3\)"),
        ({"low": 0.0}, "observer: low: 0.0"),
        ({"low": 0.9, "high": 3.0}, "a parabola through 1 only rises"),
    ],
)
def test_what_cannot_be_a_grid_is_refused(fields: dict[str, Any], words: str) -> None:
    given = {"gain": "observer", "values": np.zeros((4, 3)), **fields}
    with pytest.raises(UserError, match=words):
        replace(table(), gains=(GainGrid(**given),))


def test_factors_at_both_ends_and_between() -> None:
    for gain in DEFAULT.values():
        x = gain.limits(5e-3)
        v = np.linspace(x["least"], x["most"], 101)
        factor = 1.0 + v * (x["rise"] + x["bend"] * v)
        assert factor[0] == pytest.approx(gain.low) and factor[-1] == pytest.approx(gain.high)
        assert (np.diff(factor) > 0.0).all()
