"""Golden vectors of an export: the words that the control core must give on every target."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import (
    SIGNAL_N,
    SIGNAL_NAMES,
    TRACE_NAMES,
    ffi,
    lib,
    pointer,
    sim_set_due,
    sim_signals,
)
from sensorless.core.gains import gain_records, write_wanted
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.machine.motor import Motor
from sensorless.table.image import lookup
from sensorless.table.ks_table import KsTable, ValueFormat

Words = NDArray[np.uint32]

SEGMENTS = (
    (0.00, 0.00, 9.0, 0.0),
    (0.14, 0.36, 2.0, 0.0),
    (0.60, 0.36, 2.0, 0.5),
    (0.70, 0.10, 2.0, 0.3),
)
"""Closed loop: start [s], speed target [rated], its rate [rated/s], load [rated]; through the usual
band and back, with a load step in between."""
DURATION = 1.0
FIND = (0.0, 0.5)
"""The drive finds its rotor at rest, and once more while it spins [s]."""
NOISE_SEED = 2025


C_TYPE: dict[ValueFormat, str] = {"f32": "float", "q15": "int16_t"}
"""C type of the stored values."""


def places(table: KsTable) -> NDArray[np.float32]:
    """Signals (n, axes) to look up.

    They take edges, first nodes and middles of the axes in combination, random places inside and
    outside, and on one axis at a time infinities, NaN, huge, tiny and negative-zero numbers.
    """
    rng = np.random.default_rng(0)
    low = np.array([a.lo for a in table.axes], dtype=np.float32)
    high = np.array([a.hi for a in table.axes], dtype=np.float32)
    above = np.nextafter(low, high)
    ends = [
        [a.lo, above[j], a.nodes[1], 0.5 * (a.lo + a.hi), a.hi] for j, a in enumerate(table.axes)
    ]
    inside = low + (high - low) * rng.uniform(-0.2, 1.2, size=(32, len(low)))
    odd = [np.inf, -np.inf, np.nan, 3.4e38, -3.4e38, 1e-41, -0.0]
    centre = 0.5 * (low + high)
    single = [np.where(np.arange(len(low)) == a, x, centre) for a in range(len(low)) for x in odd]
    corners = list(itertools.islice(itertools.product(*ends), 0, None, 1 if len(low) < 3 else 7))
    return np.concatenate([np.array(corners), inside, np.array(single)]).astype(np.float32)


def table_vectors(table: KsTable, form: ValueFormat) -> Words:
    """Lookups (n, axes + 1) at `places`: the signal of each axis, then the weight."""
    at = places(table)
    obs = np.zeros((len(at), SIGNAL_N), dtype=np.float32)
    obs[:, [SIGNAL_NAMES.index(a.signal) for a in table.axes]] = at
    k_s = lookup(table.record(form).reshape(1), table.stored(form), obs)
    return np.column_stack([as_words(at), as_words(k_s)])


@dataclass(frozen=True)
class DriveVectors:
    """Consecutive PWM periods of a drive in closed loop."""

    words: Words
    """(n, 9): i_a, i_b, u_dc, omega_ref, k_s_ref in; u_a, u_b, theta, omega out."""
    start: tuple[float, float, float]
    """Angle [rad], electrical speed [rad/s] and k_s before the first one."""
    find: tuple[int, ...]
    """Periods before which the drive is told to find its rotor."""


def drive_vectors(table: KsTable, motor: Motor, design: DriveDesign, periods: int) -> DriveVectors:
    """Run a drive on its machine under the table and record inputs and outputs of ``drive_step``.

    Parameters
    ----------
    periods : int
        PWM periods from one decision of the schedule to the next.
    """
    sim = SimFactory(motor, design).build(_scenario(motor), twin=False)
    schedule = Schedule(table, periods)
    decision = periods * motor.T_s
    gains = gain_records(sim, table.ranges, decision)
    obs = np.zeros((1, SIGNAL_N), dtype=np.float32)
    n = int(sim["k_end"][0])
    out = np.zeros((n, 9), dtype=np.float32)
    i_a, i_b, u_dc = (TRACE_NAMES.index(name) for name in ("i_a", "i_b", "u_dc"))
    drives, row = pointer(sim, "sim_t[]"), ffi.new("double[]", len(TRACE_NAMES))
    s = drives[0]
    x, u = s.drive.x, s.drive.u
    start = (x.est.theta, x.est.omega, x.k_s)
    find = tuple(round(t / motor.T_s) for t in FIND)
    for j in range(n):
        if j in find:
            lib.drive_find_rotor(ffi.addressof(x))
        k_s_ref = schedule.step(s.control, x)
        if table.gains:
            if j % periods == 0:
                sim_signals(sim, obs)
                write_wanted(gains, table.evaluate_gains(obs))
            sim_set_due(sim, gains, j % periods, periods)
        if not lib.sim_trace(drives, 1, k_s_ref, row):  # the drive was lost: keep what it did
            out = out[:j]
            break
        given = row[i_a], row[i_b], row[u_dc], s.now.omega_ref, k_s_ref
        out[j] = (*given, u.a, u.b, x.est.theta, x.est.omega)
    return DriveVectors(as_words(out), start, find)


class Schedule:
    """``ks_schedule_step`` of ``core/drive/ks_schedule.h`` over a table."""

    def __init__(self, table: KsTable, periods: int) -> None:
        self._header, self._values = table.record().reshape(1), table.stored()
        self._params = ffi.new("ks_schedule_params_t *")
        self._params.table = pointer(self._header, "ks_table_t[]")
        self._params.values = pointer(self._values, "char[]")
        self._params.rule.x_min, self._params.rule.x_max = table.rule
        self._params.periods = periods
        self._state = ffi.new("ks_schedule_state_t *")
        if lib.ks_schedule_init(self._params, self._state) != lib.KS_OK:
            raise AssertionError("a valid KsTable passes the check")

    def step(self, control: Any, x: Any) -> float:
        """Weight wanted, from a drive's parameters and state in C."""
        params, signals = ffi.addressof(control, "signal"), ffi.addressof(x, "signal")
        return float(lib.ks_schedule_step(self._params, self._state, params, signals))


def _scenario(motor: Motor) -> Scenarios:
    s = Scenarios.nominal(motor, np.array([NOISE_SEED], dtype=np.uint64), DURATION)
    rated = motor.omega_m_rated
    for j, (t, omega, rate, tau) in enumerate(SEGMENTS):
        s.t[0, j], s.omega[0, j], s.omega_rate[0, j] = t, omega * rated, rate * rated
        s.tau[0, j] = tau * motor.tau_rated
    return s


def as_words(x: NDArray[np.float32]) -> Words:
    """Bits of float32 numbers; every NaN gets the same bits."""
    y = np.where(np.isnan(x), np.float32(np.nan), x).astype(np.float32)
    return y.view(np.uint32)


def hex_words(words: Words) -> str:
    """Comma-separated 32-bit literals."""
    return ", ".join(["0x%08X"] * len(words)) % tuple(words.tolist())
