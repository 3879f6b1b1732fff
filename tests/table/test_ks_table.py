"""The schedule table: lookup, check, checksum, file."""

import zlib
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES, Array, ffi, lib, pointer
from sensorless.errors import UserError
from sensorless.table.image import check, lookup, seal
from sensorless.table.ks_table import Axis, KsTable, ValueFormat

AXES = (
    Axis("speed", 0.05, 0.45, 5),
    Axis("torque_current", -1.5, 1.5, 4),
    Axis("disagreement", -1.0, 1.0, 3),
    Axis("k_s", 0.0, 1.0, 2),
)
FORMS: tuple[ValueFormat, ...] = ("f32", "q15")


def table(n_axes: int = 2, seed: int = 1) -> KsTable:
    shape = tuple(axis.n for axis in AXES[:n_axes])
    return KsTable(AXES[:n_axes], np.random.default_rng(seed).random(shape, dtype=np.float32))


def zeros(*shape: int) -> NDArray[np.float32]:
    return np.zeros(shape, dtype=np.float32)


def signals(places: NDArray[Any], axes: tuple[Axis, ...]) -> NDArray[np.float32]:
    """Rows of signals that are NaN but for the axes: nothing else may be read."""
    obs = np.full((len(places), SIGNAL_N), np.nan, dtype=np.float32)
    obs[:, [SIGNAL_NAMES.index(axis.signal) for axis in axes]] = places
    return obs


@pytest.mark.parametrize("n_axes", [1, 2, 3, 4])
def test_lookup_is_multilinear_and_clipped(n_axes: int) -> None:
    t = table(n_axes)
    low, high = (np.array([getattr(a, end) for a in t.axes]) for end in ("lo", "hi"))
    places = np.random.default_rng(2).uniform(low - 0.3, high + 0.3, size=(2000, n_axes))
    nodes = [np.linspace(a.lo, a.hi, a.n) for a in t.axes]
    reference = RegularGridInterpolator(nodes, t.values.astype(np.float64))
    expected = reference(np.clip(places, low, high))
    assert np.abs(t.evaluate(signals(places, t.axes)) - expected).max() < 2e-6


def test_nodes_read_back_as_they_are() -> None:
    t = table(2)
    grid = np.stack(np.meshgrid(*(a.nodes for a in t.axes), indexing="ij"), axis=-1)
    k_s = t.evaluate(signals(grid.reshape(-1, 2), t.axes))
    np.testing.assert_allclose(k_s, t.values.reshape(-1), atol=3e-7)


def test_two_nodes_are_the_linear_rule() -> None:
    t = KsTable((Axis("speed", 0.2, 0.8 / 3.0, 2),), np.array([1.0, 0.0], dtype=np.float32))
    speed = np.linspace(0.0, 1.0, 1001)[:, None]
    expected = np.clip((0.8 / 3.0 - speed[:, 0]) / (0.2 / 3.0), 0.0, 1.0)
    np.testing.assert_allclose(t.evaluate(signals(speed, t.axes)), expected, atol=1e-6)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_a_signal_that_is_not_finite_gives_the_fallback(bad: float) -> None:
    t = replace(table(2), fallback=0.75)
    for column in range(2):
        place = np.array([[0.2, 0.3]])
        place[0, column] = bad
        assert t.evaluate(signals(place, t.axes)) == [0.75]


@pytest.mark.parametrize("huge", [3.4e38, -3.4e38, 1e-45, -0.0, 1e20])
def test_any_finite_signal_gives_a_weight(huge: float) -> None:
    t = table(2)
    k_s = t.evaluate(signals(np.array([[huge, 0.1], [0.1, huge]]), t.axes))
    assert np.all((k_s >= 0.0) & (k_s <= 1.0))


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("n_axes", [1, 4])
def test_checksums_are_those_of_zlib(form: ValueFormat, n_axes: int) -> None:
    t = table(n_axes)
    record, values = t.record(form, motor_hash=9), t.stored(form)
    assert int(record["crc_values"]) == zlib.crc32(values.tobytes())
    assert int(record["crc_header"]) == zlib.crc32(record.tobytes()[:-4])
    assert (
        lib.ks_table_check(pointer(record.reshape(1), "ks_table_t[]"), pointer(values, "char[]"), 9)
        == lib.KS_OK
    )


@pytest.mark.parametrize("form", FORMS)
def test_q15_is_within_half_a_step_and_holds_both_ends(form: ValueFormat) -> None:
    t = table(2)
    ends = replace(t, values=np.where(t.values > 0.5, 1.0, 0.0).astype(np.float32))
    places = signals(np.random.default_rng(3).uniform(-1, 1, size=(500, 2)), t.axes)
    rounding = 2e-7
    for one, limit in ((t, 1.0 / 65534.0 + rounding), (ends, rounding)):
        k_s = lookup(one.record("q15").reshape(1), one.stored("q15"), places)
        nodes = (one.stored("q15") / 32767.0).astype(np.float32).reshape(one.values.shape)
        assert np.abs(k_s - replace(one, values=nodes).evaluate(places)).max() <= rounding
        assert np.abs(k_s - one.evaluate(places)).max() <= limit
        assert k_s.min() >= 0.0 and k_s.max() <= 1.0
    for level in (0.0, 1.0):
        flat = replace(t, values=np.full_like(t.values, level))
        assert set(lookup(flat.record("q15").reshape(1), flat.stored("q15"), places)) == {level}


def flips(raw: NDArray[np.uint8]) -> Any:
    """Every bit of an array in turn, inverted while the caller looks."""
    for j in range(8 * len(raw)):
        raw[j // 8] ^= 1 << (j % 8)
        yield j
        raw[j // 8] ^= 1 << (j % 8)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("n_axes", [1, 2, 4])
def test_every_flipped_bit_is_noticed(form: ValueFormat, n_axes: int) -> None:
    t = table(n_axes)
    header, values = t.record(form, motor_hash=9).reshape(1), t.stored(form).copy()
    assert check(header, values, 9) == lib.KS_OK
    for j in flips(header.view(np.uint8)):
        # a damaged header is refused before a single value is read
        found = lib.ks_table_check(pointer(header, "ks_table_t[]"), ffi.NULL, 9)
        assert found != lib.KS_OK, f"bit {j} of the header"
    for j in flips(values.view(np.uint8)):
        assert check(header, values, 9) == lib.KS_BAD_CRC, f"bit {j} of the values"
    assert check(header, values, 9) == lib.KS_OK


def tampered(**changes: Any) -> tuple[Array, Array]:
    """Table with header fields or nodes changed and both checksums right again."""
    t = table(2)
    header, values = t.record(motor_hash=9).reshape(1), t.stored().copy()
    for name, value in changes.items():
        if name == "node":
            values[3] = value
        elif name in ("signal", "n", "x0", "inv_step", "top"):
            header["axis"][0, 1][name] = value
        else:
            header[name] = value
    seal(header, values)
    return header, values


@pytest.mark.parametrize(
    ("changes", "problem"),
    [
        ({"magic": 0}, "MAGIC"),
        ({"format": 2}, "FORMAT"),
        ({"value_format": 0}, "FORMAT"),
        ({"n_axes": 0}, "AXES"),
        ({"n_axes": 5}, "AXES"),
        ({"n_nodes": 19}, "AXES"),
        ({"signal": SIGNAL_N}, "AXES"),
        ({"n": 1, "n_nodes": 5}, "AXES"),
        ({"x0": np.nan}, "AXES"),
        ({"inv_step": 0.0}, "AXES"),
        ({"inv_step": np.inf}, "AXES"),
        ({"top": 9.0}, "AXES"),
        ({"node": np.nan}, "VALUE"),
        ({"node": 1.0001}, "VALUE"),
        ({"node": -1e-6}, "VALUE"),
        ({"fallback": np.nan}, "VALUE"),
        ({"slew_per_s": 0.0}, "VALUE"),
        ({"motor_hash": 8}, "MOTOR"),
    ],
)
def test_the_check_names_what_is_wrong(changes: dict[str, Any], problem: str) -> None:
    assert check(*tampered(**changes), 9) == getattr(lib, f"KS_BAD_{problem}")


def test_any_motor_is_accepted_without_a_hash() -> None:
    assert check(*tampered(motor_hash=8), 0) == lib.KS_OK
    assert table().check() == lib.KS_OK


def wrong(**changes: Any) -> Any:
    """A table with fields of any kind."""
    return replace(table(), **changes)


def test_nodes_may_be_counted_by_numpy() -> None:
    axis = Axis("speed", 0.0, 1.0, np.int64(5))  # type: ignore[arg-type]
    assert axis == Axis("speed", 0.0, 1.0, 5) and type(axis.n) is int


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: Axis("omega", 0, 1, 3), "axis: 'omega' is not a signal; choose from speed,"),
        (lambda: Axis("speed", 0, 1, 1), "axis speed: n: 1; give 2 to 1024"),
        (lambda: Axis("speed", 0, 1, 1025), "axis speed: n: 1025"),
        (lambda: Axis("speed", 0, 1, True), "axis speed: n: True"),
        (lambda: Axis("speed", 1, 1, 3), "axis speed: lo, hi: 1, 1; give lo < hi"),
        (lambda: Axis("speed", np.nan, 1, 3), "axis speed: lo: nan"),
        (lambda: Axis("speed", 0, 1e39, 3), "axis speed: hi: 1e.39"),
        (lambda: KsTable((), zeros()), "axes: ; give 1 to 4 different ones"),
        (lambda: KsTable((AXES[0], AXES[0]), zeros(5, 5)), "axes: speed, speed;"),
        (lambda: KsTable(AXES[:2], zeros(4, 5)), r"shape \(4, 5\); give \(5, 4\)"),
        (
            lambda: KsTable((Axis("speed", 0, 1, 40), Axis("k_s", 0, 1, 40)), zeros(40, 40)),
            "1600 nodes; give at most 1024",
        ),
        (lambda: replace(table(), values=np.full((5, 4), np.nan)), r"node \[0, 0\]: nan; give"),
        (lambda: replace(table(), values=zeros(5, 4) + 2), r"node \[0, 0\]: 2;"),
        (lambda: replace(table(), slew_per_s=0.0), "slew_per_s: 0.0; give"),
        (lambda: replace(table(), fallback=np.nan), "fallback: nan; give"),
        (lambda: replace(table(), rule=(0.3, 0.3)), "rule: 0.3, 0.3; give low < high"),
        (lambda: wrong(provenance=[1]), r"provenance: \[1\]; give facts by name"),
        (lambda: wrong(axes=(("speed", 0, 1, 5),)), "axes: .*give a tuple of Axis"),
        (lambda: wrong(axes=AXES[0]), "axes: Axis.*; give a tuple of Axis"),
        (lambda: wrong(gains=("observer",)), "gains: .*give a tuple of GainGrid"),
        (lambda: table().evaluate_gains(np.zeros((1, SIGNAL_N), np.float32)), "gains: none"),
        (lambda: wrong().record("q31"), "form: 'q31'; give 'f32' or 'q15'"),
    ],
)
def test_what_is_out_of_range_is_named(build: Any, message: str) -> None:
    with pytest.raises(UserError, match=message):
        build()


@pytest.mark.parametrize("n_axes", [1, 2, 3, 4])
@pytest.mark.parametrize("form", FORMS)
def test_damage_after_the_check_leaves_a_weight(n_axes: int, form: ValueFormat) -> None:
    """Nodes and fallback of arbitrary bits: the lookup of a table that once passed stays safe."""
    rng = np.random.default_rng(n_axes)
    t = table(n_axes)
    header, values = t.record(form).reshape(1), t.stored(form)
    obs = signals(rng.uniform(-2.0, 2.0, (500, n_axes)), t.axes)
    odd = np.array([np.nan, np.inf, -np.inf, 3e38, -1e-30, 1.0000001], np.float32)
    kind = np.uint32 if form == "f32" else np.uint16
    for trial in range(20):
        bits = rng.integers(0, np.iinfo(kind).max, values.size, dtype=kind, endpoint=True)
        hurt = bits.view(values.dtype).reshape(values.shape).copy()
        if form == "f32" and trial % 2:
            hurt.ravel()[:] = rng.choice(odd, values.size)
        header["fallback"] = rng.choice(odd)
        k_s = lookup(header, hurt, obs)
        assert np.all((k_s >= 0.0) & (k_s <= 1.0))
    header["fallback"] = 0.25
    hurt = np.full_like(values, np.nan if form == "f32" else -5)
    assert np.all(lookup(header, hurt, obs) == 0.25)
    header["fallback"] = np.nan
    assert np.all(lookup(header, values, np.full_like(obs, np.nan)) == 1.0)
