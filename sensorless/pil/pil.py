"""Processor in the loop: an exported schedule with its control core, proven on an emulated target.

The core is exported, compiled for a Cortex-M4F, run under QEMU in lock-step with the machine on the
host, and compared with the host's core in every word of every period.
"""

import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.core.api import Array, ffi, lib
from sensorless.decision import decision_periods
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.evaluation.rollout import cause_of
from sensorless.export.export import export
from sensorless.machine.motor import Motor
from sensorless.pil.device import (
    DRIVE_IN,
    DRIVES,
    Device,
    Operation,
    lookup_items,
)
from sensorless.pil.lockstep import Lockstep, canonical, lockstep
from sensorless.pil.scenarios import pil_scenarios
from sensorless.pil.tools import (
    build,
    fused_instructions,
    memory,
    qemu_command,
    require_tools,
    stack_of,
    versions,
)
from sensorless.table.image import lookup
from sensorless.table.ks_table import KsTable

EMPTY = 2
"""Instructions of a measured empty call that are inside the called function."""

Report = dict[str, Any]

SEED = 5
"""Of the random scenarios."""
CALL = 1002
"""Instructions of ``port_thousand`` with its call and return."""


def pil(
    table: KsTable,
    motor: Motor,
    design: DriveDesign,
    *,
    policy: str = "table",
    size: int = 16,
    level: str = "-O2",
    progress: Callable[[float], None] | None = None,
) -> Report:
    """Export, compile, run and compare.

    Parameters
    ----------
    table, motor, design
        As for ``export``.
    policy : str
        Name in the report.
    size : int
        Number of scenarios, at most ``DRIVES``.
    level : str
        Optimisation level of the image.

    Returns
    -------
    dict of JSON types

    Raises
    ------
    UserError
        Cross compiler or emulator is missing, or the image does not answer.
    """
    require_tools()
    began = time.monotonic()
    names, scenarios = pil_scenarios(motor, SEED, size)
    with tempfile.TemporaryDirectory(prefix="sensorless-pil-") as temp:
        place = Path(temp)
        export(table, motor, design, place / "export", policy=policy)
        objects = place / "build"
        image = build(place / "export", objects, "image", level)
        sims = SimFactory(motor, design).build(scenarios)
        with Device(qemu_command(image), place) as device:
            info = device.ask(Operation.INFO)[0]
            run = lockstep(device, sims, table, decision_periods(motor), progress=progress)
            tests = device.ask(Operation.TESTS)[0]
            lookups = _lookups(device, table, info)
            stages = device.ask(Operation.STAGES, _running(len(scenarios), motor))
        sizes = memory(objects)
        step = "gain_schedule_step" if table.gains else "ks_schedule_step"
        stack = stack_of(objects, ("drive_step", step))
        fused = fused_instructions(image)
    return {
        "policy": policy,
        "motor": motor.name,
        "motor_digest": motor.digest,
        "estimator": design.estimator,
        "table_digest": table.digest,
        "core_hash": ffi.string(lib.core_hash).decode(),
        "level": level,
        "tools": versions(),
        "scenarios": _scenarios(names, run),
        "periods": int(run.periods.sum()),
        "mismatches": int(run.mismatches.sum()),
        "first_mismatch": run.first,
        "lookups": lookups["compared"],
        "lookup_mismatches": lookups["mismatches"],
        "target_tests": {name: int(tests[name]) for name in tests.dtype.names or ()},
        "instructions": {
            "period": _spread(run.ticks[:, 0], info),
            "drive_step": _spread(run.ticks[:, 1], info),
            **lookups["instructions"],
            **{f"part_{name}": _spread(stages[name], info) for name in stages.dtype.names or ()},
        },
        "memory": sizes,
        "flash_core": sum(sum(part.values()) for name, part in sizes.items() if name[-2:] == ".o")
        + int(info["drive_params"]) + sizes["table_f32"]["rodata"],
        "flash_table_and_check": sizes["table_f32"]["rodata"] + sizes["table_check"]["text"],
        "ram_state": int(info["drive_state"]) + int(info["schedule_state"]),
        "stack": stack,
        "fused_instructions": fused,
        "seconds": round(time.monotonic() - began, 1),
    }  # fmt: skip


def passed(report: Report) -> bool:
    """Whether nothing differs and no test on the target failed."""
    wrong = (report["mismatches"], report["lookup_mismatches"], report["fused_instructions"])
    return not any(wrong) and not any(report["target_tests"].values())


def instructions(ticks: Array, info: Array) -> Array:
    """Turn ticks of the target's counter into instructions, without those of the measurement."""
    per = (float(info["ticks_1000"]) - float(info["ticks_0"])) / CALL
    return np.rint((ticks.astype(np.float64) - float(info["ticks_0"])) / per)


def _spread(ticks: Array, info: Array) -> dict[str, float]:
    return _summary(instructions(ticks, info))


def _summary(x: Array) -> dict[str, float]:
    return {"min": float(x.min()), "mean": round(float(x.mean()), 1), "max": float(x.max())}


def _scenarios(names: tuple[str, ...], run: Lockstep) -> list[Report]:
    return [
        {
            "name": name,
            "periods": int(run.periods[j]),
            "mismatches": int(run.mismatches[j]),
            "lost": cause_of(int(run.lost[j])),
            "k_s": [float(x) for x in run.k_s[j]],
        }
        for j, name in enumerate(names)
    ]


def _lookups(device: Device, table: KsTable, info: Array) -> Report:
    """Compare lookups in both formats with the host."""
    items = lookup_items(np.random.default_rng(1), table.axes)
    found = np.concatenate(
        [device.ask(Operation.LOOKUP, items[j : j + DRIVES]) for j in range(0, len(items), DRIVES)]
    )
    call = instructions(info["ticks_call"], info) - EMPTY
    wrong = 0
    for form in ("f32", "q15"):
        want = lookup(table.record(form).reshape(1), table.stored(form), items)
        got = np.ascontiguousarray(found[f"k_s_{form}"])
        wrong += int(np.sum(canonical(got.view(np.uint32)) != canonical(want.view(np.uint32))))
    return {
        "compared": 2 * len(items),
        "mismatches": wrong,
        "instructions": {
            f"lookup_{form}": _summary(instructions(found[f"ticks_{form}"], info) - call)
            for form in ("f32", "q15")
        },
    }


def _running(n: int, motor: Motor) -> Array:
    """Inputs of a period, to count the instructions of its parts."""
    items = np.zeros(n, dtype=DRIVE_IN)
    items["i_a"], items["i_b"], items["u_dc"] = 0.3, -0.1, motor.u_dc
    items["omega_ref"] = 0.4 * motor.omega_rated
    return items
