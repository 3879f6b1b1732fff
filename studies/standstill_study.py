"""Standstill under rated load: swing of the torque, and dip by a rated impact.

    python studies/standstill_study.py [--motor paper ipmsm_2200w] [--estimator coupled smo]

Eq. 25, so injection leads; nominal parameters and sensors, the inverter with its edges. ``held``:
rated torque for 3 s, with the machine's own inertia and half of it; torque and speed, peak to peak,
over the last second. The torque is the mean of two periods: the injected current alternates, and so
does its torque, which no shaft follows. ``impact``: rated load within 2 ms on the machine's own
inertia; the largest speed of the drive and of its sensored twin. Both signs of the load, several
seeds of the noise: means and the worst. Writes ``results/studies/standstill.json``.
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.errors import in_one_line
from sensorless.evaluation.trace import Trace, lost_cause, trace
from sensorless.files import ensure_writable, write_record
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.units import RAD_S_TO_RPM
from sensorless.versions import versions

MOTORS = ("paper", "ipmsm_2200w", "pmsyrm_5600w")
ESTIMATORS = ("coupled", "flux", "smo")
INERTIAS = (1.0, 0.5)
"""Over the machine's own."""
RISE = {"held": 0.1, "impact": 0.002}
"""Time in which the load rises [s]."""
DURATION = {"held": 3.2, "impact": 1.2}
"""[s]; the load comes at 0.2 s."""
WINDOW = 1.0
"""End of the run in which the swing is measured [s]."""
LIMIT_CYCLE = 2.0
"""Swing of the speed from which it counts as one, as in ``not_held`` [% of rated]."""


def scenario(motor: Motor, case: str, sign: float, inertia: float, seed: int) -> Scenarios:
    """One scenario: at rest, then rated load of a sign."""
    s = Scenarios.nominal(motor, np.array([seed], dtype=np.uint64), DURATION[case])
    s.detailed[:], s.J[:] = True, inertia
    s.t[:, 1] = 0.2
    s.tau[:, 1:] = sign * motor.tau_rated
    s.tau_rate[:] = motor.tau_rated / RISE[case]
    return s


def at_end(t: Trace, name: str) -> Floats:
    """Column over the last ``WINDOW``, each the mean of two periods; infinite if lost."""
    if lost_cause(t):
        return np.array([-np.inf, np.inf])
    x = t[name][t["t"] > t["t"][-1] - WINDOW]
    return np.asarray(0.5 * (x[1:] + x[:-1]))


def dip(t: Trace, name: str) -> float:
    """Largest speed of a column [r/min]; infinite if the drive was lost."""
    return float("inf") if lost_cause(t) else float(RAD_S_TO_RPM * np.abs(t[name]).max())


def study(motor: Motor, design: DriveDesign, seeds: range) -> dict[str, Any]:
    """Swings [% of rated] by inertia, and dips [r/min]; drive and twin."""
    policy = make_policy("eq25", motor)

    def runs(case: str, inertia: float) -> list[Trace]:
        return [
            trace(policy, scenario(motor, case, sign, inertia, seed), motor, design)
            for sign in (1.0, -1.0)
            for seed in seeds
        ]

    out: dict[str, Any] = {}
    for inertia in INERTIAS:
        held = runs("held", inertia)
        torque, twin, speed = (
            np.array([100.0 * np.ptp(at_end(t, name)) / over for t in held])
            for name, over in (
                ("tau", motor.tau_rated),
                ("tau_twin", motor.tau_rated),
                ("omega_m", motor.omega_m_rated),
            )
        )
        out[f"J x {inertia:g}"] = {
            "torque_pct": float(torque.mean()),
            "torque_worst_pct": float(torque.max()),
            "twin_torque_pct": float(twin.mean()),
            "speed_worst_pct": float(speed.max()),
            "limit_cycle": bool(speed.max() > LIMIT_CYCLE),
        }
    impact = runs("impact", 1.0)
    for key, name in (("dip_rpm", "omega_m"), ("twin_dip_rpm", "omega_m_twin")):
        out[key] = max(dip(t, name) for t in impact)
    return out


def show(found: dict[str, dict[str, Any]], motor: str) -> Table:
    """Table for the terminal."""
    table = Table(title=f"{motor}: rated torque at standstill; peak to peak in % of rated")
    table.add_column("estimator")
    for inertia in INERTIAS:
        table.add_column(f"torque, J x {inertia:g}: mean, worst (twin)", justify="right")
        table.add_column("speed", justify="right")
    table.add_column("dip of an impact (twin), r/min", justify="right")
    for name, row in found.items():
        cells = []
        for inertia in INERTIAS:
            held = row[f"J x {inertia:g}"]
            mean, worst, twin = (
                held[f"{x}_pct"] for x in ("torque", "torque_worst", "twin_torque")
            )
            cells.append(f"{mean:.1f}, {worst:.1f} ({twin:.1f})")
            cycle = ", limit cycle" if held["limit_cycle"] else ""
            cells.append(f"{held['speed_worst_pct']:.2f}{cycle}")
        table.add_row(name, *cells, f"{row['dip_rpm']:.0f} ({row['twin_dip_rpm']:.0f})")
    return table


def main() -> None:
    """Measure, print and record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--motor", nargs="+", default=list(MOTORS), help="names or motor files")
    parser.add_argument("--estimator", nargs="+", default=list(ESTIMATORS))
    parser.add_argument("--seed", type=a_seed, default=11)
    parser.add_argument(
        "--runs", type=a_count, default=4, help="seeds of the noise, from --seed on"
    )
    parser.add_argument("--out", type=Path, default=Path("results/studies/standstill.json"))
    options = parser.parse_args()
    ensure_writable(options.out.parent)
    console, seeds = Console(width=150), range(options.seed, options.seed + options.runs)
    found: dict[str, dict[str, Any]] = {}
    for word in options.motor:
        motor = Motor.load(word)
        found[motor.name] = {
            name: study(motor, DriveDesign(estimator=name), seeds) for name in options.estimator
        }
        console.print(show(found[motor.name], motor.name))
    record = {"seeds": list(seeds), "policy": "eq25", "versions": versions(), "motors": found}
    write_record(options.out, record)
    console.print(f"wrote {options.out}")


if __name__ == "__main__":
    in_one_line(main)
