"""What a running drive does when one word of its state is damaged.

    python studies/damage_campaign.py [--motor paper] [--estimator coupled smo flux]

Drives at five speeds, without load and with 0.6 of rated torque, have run for 0.5 s. Then each word
of ``drive_state_t`` in turn gets each value of ``VALUES``, or one of its bits flipped, and the
drive goes on for 0.4 s on the code that firmware runs, drive by drive. It is astray if its angle
was lost, or at the end is more than 60 degrees off, or its speed more than 5 % of rated from that
of its twin. Writes ``results/studies/damage_campaign.json``.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from sensorless.core.api import SIGNAL_N, Array, sim_run, struct_dtype
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.errors import in_one_line
from sensorless.files import ensure_writable, write_record
from sensorless.machine.motor import Motor
from sensorless.versions import versions

STATE = struct_dtype("drive_state_t")
SHARES, LOADS = (-0.6, 0.0, 0.1, 0.4, 1.0), (0.0, 0.6)
"""Speeds and loads, over rated."""
VALUES = (np.nan, np.inf, 1e30, 1e14, 1e5, -1e3)
"""For numbers; counters and bits get flips alone."""
FLIPS = (31, 30, 28, 25, 23)
"""Bits, 31 the sign of a float, 30 to 23 its exponent."""
HANDOVER = 0.2
"""Speed over rated below which injection has the weight."""


def words(dtype: np.dtype[Any] = STATE, path: str = "") -> Iterator[tuple[str, str]]:
    """Name and kind, ``f`` or ``i``, of every word of a struct, in their order."""
    for name in dtype.names or ():
        field = dict(dtype.fields or {})[name][0]
        if field.names:
            yield from words(field, f"{path}{name}.")
        else:
            yield path + name, field.kind


def running(motor: Motor, estimator: str) -> tuple[Array, Array]:
    """Drives (n,) after 0.5 s, and their weights."""
    share, load = (x.ravel() for x in np.meshgrid(SHARES, LOADS))
    s = Scenarios.nominal(motor, np.arange(len(share), dtype=np.uint64), 10.0)
    s.omega[:] = (share * motor.omega_rated / motor.n_p)[:, None]
    s.omega_0 = s.omega[:, 0].copy()
    s.tau[:] = (load * motor.tau_rated)[:, None]
    s.tau_rate[:] = motor.tau_rated / 0.2
    sims = SimFactory(motor, DriveDesign(estimator=estimator)).build(s)
    sims["go_on"] = 1
    k_s = (np.abs(share) < HANDOVER).astype(np.float32)
    sim_run(sims, round(0.5 / motor.T_s), k_s, np.zeros((len(sims), SIGNAL_N), np.float32))
    return sims, k_s


def damaged(sims: Array) -> Array:
    """Copies (words, ways, n) of drives (n,), each with one word damaged in one way."""
    kinds = [kind for _, kind in words()]
    out = np.tile(sims, (len(kinds), len(VALUES) + len(FLIPS), 1))
    x = np.ascontiguousarray(out["drive"]["x"]).view(np.uint32).reshape(*out.shape, -1)
    for j, kind in enumerate(kinds):
        for v, value in enumerate(VALUES if kind == "f" else ()):
            x[j, v, :, j] = np.float32(value).view(np.uint32)
        for b, bit in enumerate(FLIPS):
            x[j, len(VALUES) + b, :, j] ^= np.uint32(1 << bit)
    out["drive"]["x"] = x.view(STATE).reshape(out.shape)
    return out


def run(motor: Motor, estimator: str) -> dict[str, NDArray[np.bool_]]:
    """``flagged``, ``astray`` and ``infinite`` (a voltage), each (words, ways, drives)."""
    sims, k_s = running(motor, estimator)
    if sims["lost"].any() or sims["drive"]["x"]["fault"].any():
        raise RuntimeError("a drive is lost or flagged before its state is damaged")
    cases = damaged(sims)
    flat, weight = cases.reshape(-1), np.tile(k_s, cases.size // len(k_s))
    obs = np.zeros((cases.size, SIGNAL_N), np.float32)
    infinite = np.zeros(cases.size, dtype=bool)
    for periods in (1, 1, 2, 4, 8, 16, round(0.4 / motor.T_s) - 32):
        sim_run(flat, periods, weight, obs, plain=True)
        u = flat["drive"]["u"]
        infinite |= ~np.isfinite(u["a"]) | ~np.isfinite(u["b"])
    x, y, twin = flat["drive"]["x"], flat["drive"]["y"], flat["twin"]["y"]
    err = np.abs(np.angle(np.exp(1j * (y["theta_e"] - x["est"]["theta"]))))
    off = np.abs(y["omega_m"] - twin["omega_m"]) * motor.n_p / motor.omega_rated
    astray = (flat["lost"] != 0) | (err > np.pi / 3.0) | (off > 0.05)
    found = {"flagged": x["fault"] != 0, "astray": astray, "infinite": infinite}
    return {name: np.asarray(rows).reshape(cases.shape) for name, rows in found.items()}


def main() -> None:
    """Run, print and record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--motor", default="paper", help="name or motor file")
    parser.add_argument("--estimator", nargs="+", default=["coupled", "smo", "flux"])
    parser.add_argument("--out", type=Path, default=Path("results/studies/damage_campaign.json"))
    options = parser.parse_args()
    ensure_writable(options.out.parent)
    motor, console = Motor.load(options.motor), Console()
    names = [name for name, _ in words()]
    record: dict[str, Any] = {"motor": motor.name, "versions": versions()}
    for estimator in options.estimator:
        found = run(motor, estimator)
        silent = found["astray"] & ~found["flagged"]
        by_word = dict(zip(names, silent.sum(axis=(1, 2)).tolist(), strict=True))
        record[estimator] = {
            "cases": int(silent.size),
            "flagged": int(found["flagged"].sum()),
            "infinite_voltage": int(found["infinite"].sum()),
            "astray_unflagged": int(silent.sum()),
            "by_word": {name: count for name, count in by_word.items() if count},
        }
        table = Table("drives", title=f"{motor.name}, {estimator}")
        table.add_column("number", justify="right")
        for name, count in record[estimator].items():
            if name != "by_word":
                table.add_row(name.replace("_", " "), str(count))
        for name, count in record[estimator]["by_word"].items():
            table.add_row(f"  by {name}", str(count))
        console.print(table)
    write_record(options.out, record)
    console.print(f"wrote {options.out}")


if __name__ == "__main__":
    in_one_line(main)
