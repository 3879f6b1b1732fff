"""Logs of a drive in CSV, which ``sensorless replay`` reads and ``simulate --log`` writes.

There is one row per PWM period, sampled at ``t``; ``docs/replay.md`` has all columns with units.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from sensorless.core.api import REPLAY_IN, Array
from sensorless.errors import UserError
from sensorless.evaluation.trace import Trace
from sensorless.files import write_atomic
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.machine.phases import clarke, duties, leg_losses, with_third
from sensorless.recording import read_recording
from sensorless.replay.channels import of_dead, of_little, of_size, of_still, of_sum
from sensorless.replay.signature import (
    are_percent,
    is_degrees,
    of_voltage,
    time_scale,
    usual_step,
)

VOLTAGES = (("u_alpha", "u_beta"), ("u_a", "u_b", "u_c"), ("d_a", "d_b", "d_c", "u_dc"))
"""Ways to give the voltage; the first complete one is used."""
CURRENTS = ("i_a", "i_b", "i_c")
COLUMNS = ("t", *CURRENTS, *sum(VOLTAGES, ()), "inj", "theta_e", "theta_m")
JITTER = 0.01
"""Largest deviation of a period that counts as uniform, over the period."""
MOST_ROUNDING = 0.3
"""Largest rounding of the times over the period, at which a row that is missing still shows."""
MOST_SPEED = 10.0
"""Largest plausible speed over rated."""
ROUNDED = 0.01
"""How far a duty cycle may lie beyond 0 and 1, by rounding and a dead time that is put in."""
BEYOND = 3.0
"""Largest plausible reading, over the converter's range or the trip, and over the DC link."""


@dataclass(frozen=True)
class Log:
    """A recorded run of n periods; row k is the sampling instant t[k]."""

    t: Floats
    """(n,) [s]"""
    i: Floats
    """(n, 2) phase currents a and b [A], free of a common part"""
    u: Floats
    """(n, 2) stator voltage alpha, beta [V] over [t[k-1], t[k]]; 0 in row 0"""
    u_dc: Floats
    """(n,) [V]"""
    inj: Floats | None
    """(n,) sign of the injection over [t[k-1], t[k]], if recorded"""
    theta_e: Floats | None
    """(n,) angle of the encoder, electrical [rad], if recorded"""
    notes: tuple[str, ...] = ()
    """what was taken for what, and what looks wrong"""
    doubtful: bool = False
    """it contradicts itself, or holds nothing to judge by"""

    def rows(self) -> Array:
        """Rows of REPLAY_IN, shape (n,)."""
        rows = np.zeros(len(self.t), dtype=REPLAY_IN)
        rows["i_a"], rows["i_b"] = self.i.T
        rows["u_a"], rows["u_b"] = self.u.T
        rows["u_dc"] = self.u_dc
        rows["inj"] = 0.0 if self.inj is None else self.inj
        rows["infer"] = float(self.inj is None)
        return rows


def write_log(t: Trace, path: Path) -> None:
    """Write a traced run as its drive could have recorded it, with an encoder."""
    u = np.stack([t["u_alpha"], t["u_beta"]], axis=-1)
    head = "t,i_a,i_b,u_alpha,u_beta,inj,d_a,d_b,d_c,u_dc,theta_e"
    columns = [np.round(t["t"], 9)]
    columns += [t[n] for n in ("i_a", "i_b", "u_alpha_hat", "u_beta_hat", "inj")]
    columns += [*duties(u, t["u_dc"]).T, t["u_dc"], t["theta_e"]]
    form = ",".join(["%.9g"] * 5 + ["%d"] + ["%.6f"] * 3 + ["%.9g"] * 2)
    lines = [form % tuple(row) for row in np.stack(columns, axis=-1)]
    write_atomic(path, "\n".join([head, *lines]) + "\n")


def read_log(
    path: Path,
    motor: Motor,
    *,
    u_dt: float,
    inv_i_dt: float,
    delay: int = 0,
    names: Mapping[str, str] | None = None,
) -> Log:
    """Read a log.

    Parameters
    ----------
    motor : Motor
        Its period must be the log's, its pole pairs turn a mechanical angle into an electrical one,
        and its DC-link voltage replaces a missing column.
    u_dt, inv_i_dt : float
        Dead-time voltage per leg [V] that is subtracted from duty cycles against the measured
        current, and the slope of its transition [1/A], as in the drive's own compensation.
    delay : int
        Rows from a logged voltage to the row where it begins to act: 0 if it acts over the period
        that begins with its row, 1 if it was computed from the row's sample.
    names : mapping, optional
        Names in the file of columns that have others, see ``read_recording``.

    Raises
    ------
    UserError
        The file cannot be read; the message names file, line and column.
    """
    where = f"log {str(path)!r}"
    recording = read_recording(path, COLUMNS, names or {}, where)
    columns, lines = recording.columns, recording.lines
    for name in ("i_a", "i_b"):
        if name not in columns:
            taken = {of.removeprefix("-").strip(): k for k, of in (names or {}).items()}.get(name)
            why = "missing" if taken is None else f"--map reads it as {taken}"
            raise UserError(
                f"{where}: column {name}: {why}; name it with --map {name}=COLUMN; the file has "
                f"{', '.join(recording.names)[:200]}"
            )
    notes = list(_put_right(columns, motor))
    t = columns["t"]
    _check_time(t, lines, motor, where)
    _check_sizes(columns, lines, motor, where)
    i = _currents(columns)
    u_dc = columns.get("u_dc", np.full(len(t), motor.u_dc))
    inj = columns.get("inj")
    if inj is not None:
        wrong = np.flatnonzero(~np.isin(inj, (-1.0, 0.0, 1.0)))
        if len(wrong):
            raise UserError(
                f"{where}: line {lines[wrong[0]]}: inj: {inj[wrong[0]]:g}; give -1, 0 or 1"
            )
    theta_e = columns.get("theta_e")
    if theta_e is None and "theta_m" in columns:
        theta_e = motor.n_p * columns["theta_m"]
    u = _later(_voltage(columns, i, u_dc, u_dt, inv_i_dt, where), 1 + delay)
    vector = clarke(with_third(*i.T))
    commanded = _later(_voltage(columns, i, u_dc, 0.0, inv_i_dt, where), 1 + delay)
    measured = {name: columns[name] for name in CURRENTS if name in columns}
    doubts = (  # the voltage without what a dead time adds of the samples' noise
        *of_dead(measured),
        *of_still({name: columns[name] for name in _way(columns, where) if name != "u_dc"}),
        *of_sum(measured),
        *of_size(commanded, vector, motor),
        *of_voltage(commanded, vector, delay),
    )[:1]
    if not doubts:
        notes += of_little(i, motor)
    return Log(
        t=t,
        i=i,
        u=u,
        u_dc=u_dc,
        inj=None if inj is None else _later(inj, 1 + delay),
        theta_e=theta_e,
        notes=(*notes, *doubts),
        doubtful=bool(doubts),
    )


def _put_right(columns: dict[str, Floats], motor: Motor) -> Iterator[str]:
    """Bring columns to their units where what they hold shows another; says which."""
    if "t" not in columns:
        columns["t"] = np.asarray(motor.T_s * np.arange(len(columns["i_a"])), dtype=np.float64)
        yield f"no time: one row a PWM period, {motor.T_s:g} s, is assumed"
    scale, unit = time_scale(columns["t"], motor.T_s)
    if unit != "s":
        columns["t"] = scale * columns["t"]
        yield f"t: taken as {unit}"
    top = MOST_SPEED * motor.omega_rated
    for name, fastest in (("theta_e", top), ("theta_m", top / motor.n_p)):
        if name in columns and is_degrees(columns[name], motor.T_s, fastest):
            columns[name] = np.radians(columns[name])
            yield f"{name}: taken as degrees"
    duties = [name for name in VOLTAGES[2][:3] if name in columns]
    if duties and are_percent(np.stack([columns[name] for name in duties], axis=-1)):
        columns |= {name: 0.01 * columns[name] for name in duties}
        yield f"{', '.join(duties)}: taken as percent"


def _later(x: Floats, rows: int) -> Floats:
    """Move a column down by some rows, with zeros before."""
    return np.asarray(np.concatenate([np.zeros_like(x[:rows]), x[:-rows]]))


def _currents(columns: dict[str, Floats]) -> Floats:
    """Two phase currents (n, 2); with a third one their common part is removed."""
    two = np.stack([columns["i_a"], columns["i_b"]], axis=-1)
    if "i_c" not in columns:
        return two
    return np.asarray(two - ((two.sum(axis=1) + columns["i_c"]) / 3.0)[:, None])


def _way(columns: dict[str, Floats], where: str) -> tuple[str, ...]:
    """Columns that give the voltage."""
    way = next((names for names in VOLTAGES if all(n in columns for n in names)), None)
    if way is None:
        given = "; or ".join(", ".join(names) for names in VOLTAGES)
        raise UserError(f"{where}: line 1: no complete voltage; give {given}")
    return way


def _voltage(
    columns: dict[str, Floats], i: Floats, u_dc: Floats, u_dt: float, inv_i_dt: float, where: str
) -> Floats:
    """Stator voltage (n, 2) [V] over the period that begins with each row."""
    way = _way(columns, where)
    values = np.stack([columns[n] for n in way], axis=-1)
    if way == VOLTAGES[0]:
        return values
    if way == VOLTAGES[1]:
        return clarke(values)
    off = np.argwhere(np.abs(values[:, :3] - 0.5) > 0.5 + ROUNDED)
    if len(off):
        row, phase = off[0]
        raise UserError(
            f"{where}: {way[phase]}: {values[row, phase]:g}; give duty cycles from 0 to 1, or 0 to "
            "100 %: a compare value over that of a whole period, or 0.5 + 0.5 m for a modulation m "
            "from -1 to 1"
        )
    over = 0.5 * (i + np.concatenate([i[1:], i[-1:]]))  # mean of the samples around the period
    loss = leg_losses(with_third(*over.T), u_dt, inv_i_dt)
    return clarke(values[:, :3] * u_dc[:, None] - loss)


def _check_time(t: Floats, lines: Array, motor: Motor, where: str) -> None:
    """Refuse another period and gaps; steps may differ by what the column is rounded to."""
    if len(t) < 3:
        raise UserError(f"{where}: {len(t)} of at least 3 rows; record more")
    step, period = np.diff(t), usual_step(t)
    if abs(period - motor.T_s) > JITTER * motor.T_s:
        raise UserError(
            f"{where}: t: {period:g} s from row to row, but motor {motor.name!r} has T_s = "
            f"{motor.T_s:g} s; log every PWM period, or give the motor with this period"
        )
    apart = np.diff(np.sort(step))  # of steps that differ: what the times are rounded to
    rounded = np.min(apart, initial=motor.T_s, where=apart > 0.1 * JITTER * motor.T_s)
    most = max(JITTER * motor.T_s, rounded if rounded < MOST_ROUNDING * motor.T_s else 0.0)
    wrong = np.flatnonzero(np.abs(step - motor.T_s) > most)
    if len(wrong):
        raise UserError(
            f"{where}: line {lines[wrong[0] + 1]}: t: {step[wrong[0]]:g} s after the row before; "
            f"log every PWM period, {motor.T_s:g} s, without gaps"
        )


def _check_sizes(columns: dict[str, Floats], lines: Array, motor: Motor, where: str) -> None:
    """Refuse readings that this drive cannot have made."""
    current = BEYOND * max(motor.i_trip, motor.adc_range)
    bounds = {
        **{name: (-current, current, "A") for name in CURRENTS},
        **{
            name: (-BEYOND * motor.u_dc, BEYOND * motor.u_dc, "V") for name in sum(VOLTAGES[:2], ())
        },
        "u_dc": (1e-3 * motor.u_dc, BEYOND * motor.u_dc, "V"),
    }
    for name, (low, high, unit) in bounds.items():
        values = columns.get(name, np.zeros(0))
        wrong = np.flatnonzero((values < low) | (values > high))
        if len(wrong):
            raise UserError(
                f"{where}: line {lines[wrong[0]]}: {name}: {values[wrong[0]]:g} {unit}, "
                f"{len(wrong)} of {len(lines)} rows beyond {low:.4g} to {high:.4g} {unit}, which "
                f"motor {motor.name!r} makes plausible; check its unit, or mend or cut these rows"
            )
