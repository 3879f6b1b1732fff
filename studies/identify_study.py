"""Let simulated drives identify random machines, and compare with the truth.

    python studies/identify_study.py

Every machine of the family has its own errors of sensors and inverter, drawn as in the suite
`stress`; `--details` adds harmonics, iron loss and the ripple of the DC link. An inductance is
judged by its largest relative error over the operating line and both axes, up to rated current.
Some machines then run the suite `nominal` under Eq. 25 twice: with a control designed for the true
machine and with one designed for what was identified.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.control import operating_line
from sensorless.design.drive import DriveDesign
from sensorless.design.records import control_record
from sensorless.envs.scenarios.machine_family import NAME, family
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import UserError, in_one_line
from sensorless.evaluation.evaluate import score
from sensorless.files import check_writable, ensure_writable, write_record
from sensorless.identify.machine.nameplate import Nameplate
from sensorless.identify.machine.procedure import identify_machine
from sensorless.identify.machine.result import motor_tables
from sensorless.identify.machine.simulated import Simulated, real_drive
from sensorless.machine.magnetics import Floats, flux, inverse_inductance
from sensorless.machine.motor import Motor, Saturation
from sensorless.policies.registry import make_policy
from sensorless.versions import versions

BARS = {"R_s": 0.03, "psi_f": 0.02, "L_d": 0.05, "L_q": 0.05, "J": 0.10}
"""Largest relative errors that count as met."""


def inductance_errors(motor: Motor, found: Saturation) -> tuple[float, float]:
    """Largest relative errors of the incremental L_d and L_q within rated current."""
    line = operating_line(motor, True)
    side = np.linspace(0.0, motor.i_rated, 31)
    zero = np.zeros(31)
    i = np.concatenate(
        [
            line[np.hypot(*line.T) <= motor.i_rated],
            np.stack([-side, zero], axis=-1),
            np.stack([zero, side], axis=-1),
        ]
    )
    true, own = (_inductances(s, i) for s in (motor.saturation, found))
    d, q = np.abs(own / true - 1.0).max(axis=0)
    return float(d), float(q)


def _inductances(s: Saturation, i: Floats) -> Floats:
    full = np.linalg.inv(inverse_inductance(s, flux(s, i)))
    return np.asarray(full[:, (0, 1), (0, 1)])


def identified(motor: Motor, seed: int, details: bool) -> tuple[dict[str, Any], Motor | None]:
    """Relative errors of one machine, or why it was not identified; and the machine found."""
    scenario = real_drive(motor, seed, details)
    gain = float(np.sqrt(np.prod(scenario.gain[0])))
    try:
        found = Motor.from_tables(
            motor_tables(identify_machine(Simulated(motor, scenario), Nameplate.of(motor))),
            motor.name,
        )
        L_d, L_q = inductance_errors(motor, found.saturation)
    except UserError as error:
        return {"refused": str(error), "gain": gain - 1.0}, None
    errors = {
        "R_s": found.R_s / motor.R_s - 1.0,
        "psi_f": found.psi_f / motor.psi_f - 1.0,
        "L_d": L_d,
        "L_q": L_q,
        "J": found.J / motor.J - 1.0,
        "gain": gain - 1.0,
        "R_s with the gain known": found.R_s * gain / motor.R_s - 1.0,
    }
    return errors, found


def driven(motor: Motor, found: Motor, seed: int, size: int) -> dict[str, Any]:
    """Lost rate and torque deviation with the control of the true and of the found machine."""
    design, out = DriveDesign(), {}
    rows = SuiteRows("nominal", motor, seed, size)
    for name, known in (("true", motor), ("identified", found)):
        factory = SimFactory(motor, design)
        factory.template["control"] = control_record(known, design)
        scores = score(make_policy("eq25", known), rows, factory)
        kept = scores.lost == 0
        out[name] = {
            "lost": int(np.sum(~kept)),
            "torque_dev": float(np.mean(scores.metrics["torque_dev_rms"][kept])),
        }
    return out


def summary(machines: list[dict[str, Any]]) -> dict[str, Any]:
    """Share within each bar, and median, 95 % and largest of the magnitudes of the errors."""
    known = [m for m in machines if "refused" not in m]
    out: dict[str, Any] = {"machines": len(machines), "identified": len(known)}
    for name in (*BARS, "gain", "R_s with the gain known"):
        size = np.abs([m[name] for m in known])
        out[name] = {
            "median": float(np.median(size)),
            "95 %": float(np.quantile(size, 0.95)),
            "worst": float(size.max()),
        }
        if name in BARS:
            out[name]["within"] = int(np.sum(size <= BARS[name]))
    out["all within"] = sum(all(abs(m[k]) <= bar for k, bar in BARS.items()) for m in known)
    return out


def main() -> None:
    """Identify, drive, write and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seed", type=a_seed, default=13, help="of the family and of the errors")
    parser.add_argument("--size", type=a_count, default=64, help="machines")
    parser.add_argument("--details", action="store_true", help="harmonics, iron loss, link ripple")
    parser.add_argument("--drive", type=int, default=8, help="machines to drive; 0: none")
    parser.add_argument("--scenarios", type=a_count, default=100, help="of each machine driven")
    parser.add_argument("--out", type=Path, default=Path("results/studies/identify.json"))
    args = parser.parse_args()
    ensure_writable(args.out.parent)
    check_writable(args.out)
    machines: list[dict[str, Any]] = []
    runs: dict[str, Any] = {}
    for j, motor in enumerate(family(args.seed, args.size)):
        errors, found = identified(motor, args.seed + j, args.details)
        machines.append({"machine": motor.name, **errors})
        if found is not None and len(runs) < args.drive:
            runs[motor.name] = driven(motor, found, args.seed, args.scenarios)
        print(json.dumps({**machines[-1], **runs.get(motor.name, {})}), flush=True)
    record = {
        "family": NAME,
        "seed": args.seed,
        "details": args.details,
        "summary": summary(machines),
        "driven": runs,
        "machines": machines,
        "versions": versions(),
    }
    write_record(args.out, record)
    print(json.dumps(record["summary"], indent=1))


if __name__ == "__main__":
    in_one_line(main)
