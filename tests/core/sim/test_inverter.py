"""Averaged inverter and converter: hexagon, dead time, quantiser."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from sensorless.core.api import SENSOR, Array
from sensorless.design.records import sensor_record
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor

Call = Callable[..., None]
Complexes = np.ndarray[tuple[int], np.dtype[np.complex128]]

U_DC = 540.0


def pairs(z: Complexes) -> Array:
    return np.ascontiguousarray(np.stack([z.real, z.imag], axis=-1), dtype=np.float32)


def circle(radius: float, n: int = 720) -> Complexes:
    return np.asarray(radius * np.exp(2j * np.pi * np.arange(n) / n))


def inverter(c: Call, u: Complexes, i: Complexes, dead_time_share: float = 0.0) -> Complexes:
    p = np.zeros(1, dtype=SENSOR)
    p["dead_time_share"], p["inv_i_zero"] = dead_time_share, 1.0 / 0.05
    y = np.empty((len(u), 2), dtype=np.float32)
    c("inverter", p, pairs(u), U_DC, pairs(i), y, len(u))
    return np.asarray(y[:, 0] + 1j * y[:, 1].astype(float))


def phases(z: Complexes) -> Floats:
    """Three phase values of a vector, shape (n, 3)."""
    return np.stack([(z * np.exp(-2j * np.pi * k / 3)).real for k in range(3)], axis=-1)


def test_exact_up_to_the_inscribed_circle(c: Call) -> None:
    """Every direction gets u_dc / sqrt(3) unchanged."""
    u = circle(0.9999 * U_DC / math.sqrt(3.0))
    assert np.max(np.abs(inverter(c, u, 0 * u) - u)) < 1e-3


@pytest.mark.parametrize("radius", [320.0, 360.0, 500.0, 2000.0])
def test_never_outside_of_the_hexagon(c: Call, radius: float) -> None:
    """No line voltage exceeds the link, and the hexagon is used to its corners."""
    out = phases(inverter(c, circle(radius), 0 * circle(radius)))
    line = np.max(out, axis=1) - np.min(out, axis=1)
    assert np.max(line) <= U_DC * (1.0 + 1e-6)
    assert np.max(np.abs(out)) <= 2.0 / 3.0 * U_DC * (1.0 + 1e-6)
    if radius > 360.0:
        assert np.max(np.abs(out)) == pytest.approx(2.0 / 3.0 * U_DC, rel=1e-5)


def test_dead_time_acts_against_the_current(c: Call) -> None:
    """Six steps of 4/3 u_dt against the current; fundamental 4 u_dt / pi."""
    u_dt = U_DC * 0.01
    i, u = circle(5.0), circle(100.0)
    lost = inverter(c, u, i, 0.01) - u
    assert np.mean((lost * np.conj(i)).real) < 0.0
    assert np.max(np.abs(lost)) == pytest.approx(4.0 / 3.0 * u_dt, rel=1e-3)
    fundamental = np.mean(lost * np.conj(i / np.abs(i)))
    assert fundamental.real == pytest.approx(-4.0 / math.pi * u_dt, rel=0.01)
    assert abs(fundamental.imag) < 0.02 * u_dt


def test_dead_time_by_sign_of_each_phase(c: Call) -> None:
    """Current into phase a and out of b and c: a loses, b and c gain."""
    u = np.array([50.0 + 0.0j])
    lost = phases(inverter(c, u, np.array([3.0 + 0.0j]), 0.01) - u)[0]
    assert lost == pytest.approx([-7.2, 3.6, 3.6], abs=1e-3)
    back = phases(inverter(c, u, np.array([-3.0 + 0.0j]), 0.01) - u)[0]
    assert back == pytest.approx([7.2, -3.6, -3.6], abs=1e-3)
    assert np.abs(inverter(c, u, np.array([0.0j]), 0.01) - u) == pytest.approx(0.0, abs=1e-4)


def test_compensation_undoes_the_dead_time(c: Call) -> None:
    """The control's compensation has the sign and size that cancel the inverter's loss."""
    i, u = circle(5.0, 360), circle(100.0, 360)
    comp = np.empty((len(i), 2), dtype=np.float32)
    c("dead_time", U_DC * 0.01, 1.0 / 0.05, pairs(i), comp, len(i))
    command = u + comp[:, 0] + 1j * comp[:, 1]
    assert np.max(np.abs(inverter(c, command, i, 0.01) - u)) < 1e-3


def quantise(c: Call, sensor: Array, i: Floats) -> Floats:
    x = np.asarray(i, dtype=np.float32)
    y = np.empty_like(x)
    c("quantise", sensor, x, y, len(x))
    return y.astype(float)


def test_quantiser(c: Call, motor: Motor) -> None:
    """Steps of range / 2^11, rounded to nearest, odd, limited to the range."""
    sensor = sensor_record(motor).reshape(1)
    lsb = 2.0 * motor.adc_range / 2**motor.adc_bits
    i = np.linspace(-9.9, 9.9, 50_001)
    y = quantise(c, sensor, i)
    assert np.max(np.abs(y - i)) <= 0.5 * lsb + 2e-6
    assert np.max(np.abs(y / lsb - np.rint(y / lsb))) < 1e-3
    assert len(np.unique(np.rint(y / lsb))) == pytest.approx(19.8 / lsb, abs=2)
    assert np.array_equal(quantise(c, sensor, -i), -y)
    assert quantise(c, sensor, np.array([50.0, -50.0, 0.0])).tolist() == [10.0, -10.0, 0.0]
