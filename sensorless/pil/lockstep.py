"""Runs drives in lock-step with a device that runs the control core, and compares every word."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import (
    SIGNAL_N,
    SIM,
    Array,
    lib,
    pointer,
    sim_run,
    sim_set_due,
    sim_signals,
)
from sensorless.core.gains import gain_records, write_wanted
from sensorless.core.runs import running
from sensorless.pil.device import (
    DRIVE_IN,
    DRIVES,
    STEP_ANSWER,
    Device,
    Operation,
    start_items,
)
from sensorless.table.ks_table import KsTable

Words = NDArray[np.uint32]
Progress = Callable[[float], None]

_X_AT = (SIM.fields["drive"][1] + SIM["drive"].fields["x"][1]) // 4  # type: ignore[index]
_X_N = SIM["drive"]["x"].itemsize // 4
_U_AT = (SIM.fields["drive"][1] + SIM["drive"].fields["u"][1]) // 4  # type: ignore[index]
WORDS: int = STEP_ANSWER.fields["ticks"][1] // 4  # type: ignore[index]
"""Words compared per period: state of the drive, state of the schedule, voltage."""


@dataclass
class Lockstep:
    """Result for n drives."""

    periods: NDArray[np.int64]
    """(n,) periods compared"""
    mismatches: NDArray[np.int64]
    """(n,) words that differ"""
    first: tuple[int, int, int] | None
    """drive, period and word of the first difference"""
    lost: NDArray[np.int32]
    """(n,) LOST_* bits"""
    ticks: NDArray[np.uint32]
    """(total, 2) per compared period: with the schedule, and ``drive_step`` alone"""
    k_s: NDArray[np.float32]
    """(n, 2) smallest and largest weight"""


def canonical(words: Words) -> Words:
    """Replace every NaN by the same word."""
    nan = np.isnan(words.view(np.float32))
    return np.where(nan, np.uint32(0x7FC00000), words)


def lockstep(
    device: Device,
    sims: Array,
    table: KsTable,
    periods: int,
    *,
    plain: bool = False,
    progress: Progress | None = None,
) -> Lockstep:
    """Run drives to their ends, with the device's voltages on their machines.

    In every period the host's control core gets the same samples, and all words of both are
    compared. The device keeps its own states from the start on.

    Parameters
    ----------
    device : Device
    sims : array of SIM, shape (n,)
        Started drives, changed in place; at most ``DRIVES``.
    table : KsTable
        The schedule that was exported.
    periods : int
        PWM periods from one decision to the next.
    plain : bool
        The host runs drive by drive instead of in blocks of vector code.

    Raises
    ------
    ValueError
        No drives, or more than ``DRIVES``.
    """
    n = len(sims)
    if not 1 <= n <= DRIVES:
        raise ValueError(f"sims: {n} drives; give 1 to {DRIVES}")
    raw = sims.view(np.uint32).reshape(n, -1)
    obs = np.zeros((n, SIGNAL_N), dtype=np.float32)
    k_s = np.ones(n, dtype=np.float32)
    inputs = np.zeros(n, dtype=DRIVE_IN)
    schedule = np.zeros(n, dtype=STEP_ANSWER["schedule"])
    schedule["check"] = lib.KS_GOOD
    decision = periods * float(sims["control"]["T_s"][0])
    gains = gain_records(sims, table.ranges, decision)
    out = Lockstep(
        np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64), None, sims["lost"],
        np.zeros((0, 2), dtype=np.uint32), np.tile(np.array([2.0, -1.0], dtype=np.float32), (n, 1)),
    )  # fmt: skip
    ticks = []
    sim_signals(sims, obs)
    x = sims["drive"]["x"]
    begun = device.ask(
        Operation.START,
        start_items(
            x["est"]["theta"], x["est"]["omega"], x["k_s"], x["start"]["phase"] != lib.START_DONE
        ),
    )
    _compare(out, begun.view(np.uint32).reshape(n, -1)[:, :_X_N], raw[:, _X_AT : _X_AT + _X_N],
             np.ones(n, dtype=bool), -1)  # fmt: skip
    total = int(sims["k_end"].max())
    for k in range(total):
        active = running(sims)
        if not active.any():
            break
        if k % periods == 0:
            k_s = table.evaluate(obs)
            if table.gains:
                write_wanted(gains, table.evaluate_gains(obs))
        sim_set_due(sims, gains, k % periods, periods)
        schedule["k_s_ref"], schedule["wait"] = k_s, periods - 1 - k % periods
        lib.sim_inputs(pointer(sims, "sim_t[]"), n, pointer(inputs, "drive_in_t[]"))
        device.send(Operation.STEP, inputs)
        sim_run(sims, 1, k_s, obs, plain=plain)
        answer = device.receive(Operation.STEP, n)
        got = answer.view(np.uint32).reshape(n, -1)
        u = slice(_U_AT, _U_AT + 2)
        decided = schedule.view(np.uint32).reshape(n, -1)
        want = np.concatenate([raw[:, _X_AT : _X_AT + _X_N], decided, raw[:, u]], axis=1)
        _compare(out, got[:, :WORDS], want, active, k)
        raw[active, u] = got[active, WORDS - 2 : WORDS]
        out.periods += active
        ticks.append(np.stack([answer["ticks"], answer["ticks_drive"]], axis=-1)[active])
        weight = answer["x"]["k_s"]
        out.k_s[active, 0] = np.minimum(out.k_s[active, 0], weight[active])
        out.k_s[active, 1] = np.maximum(out.k_s[active, 1], weight[active])
        if progress is not None and k % 100 == 0:
            progress(k / total)
    out.lost = sims["lost"].copy()
    out.ticks = np.concatenate(ticks)
    return out


def _compare(out: Lockstep, got: Words, want: Words, active: NDArray[np.bool_], k: int) -> None:
    differs = got != want
    if not differs.any():
        return
    differs = (canonical(got) != canonical(want)) & active[:, None]
    out.mismatches += differs.sum(axis=1)
    if out.first is None and differs.any():
        drive, word = np.argwhere(differs)[0]
        out.first = (int(drive), k, int(word))
