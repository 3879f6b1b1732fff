"""Does the averaged inverter flatter? The same scenarios on it and on a switching carrier.

    python studies/carrier_study.py

Runs policies on the sliding-mode observer over suites with both inverter models, pairs them
scenario by scenario, adds the ripple that a switching inverter has between samples, and writes
``results/studies/carrier.json``.
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from sensorless.cli.study_numbers import a_seed
from sensorless.core.api import CARRIER_NAMES, PLANT_STATE
from sensorless.core.machine import carrier_run
from sensorless.design.drive import DriveDesign
from sensorless.design.records import plant_record, sensor_record
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.errors import in_one_line
from sensorless.evaluation.aggregate import paired, summary
from sensorless.evaluation.evaluate import score
from sensorless.files import ensure_writable, write_record
from sensorless.machine.magnetics import flux, mtpa, torque
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.versions import versions

POLICIES = ("eq25", "hysteresis", "gated", "constant:1", "sensored")
SUITES = {"handoff": 208, "stress-1": 200}
COLUMNS = {
    "lost_rate": ("lost [%]", 100.0),
    "torque_dev_rms": ("torque dev. [%]", 100.0),
    "torque_ripple_rms": ("torque ripple [%]", 100.0),
    "torque_ripple_lf_rms": ("... without injection band [%]", 100.0),
    "torque_p2p_handover": ("peak to peak [%]", 100.0),
    "speed_dev_rms": ("speed dev.", 100.0),
    "angle_err_rms_deg": ("angle error [°]", 1.0),
}
POINTS = ((0.05, 0.0), (0.05, 0.5), (0.23, 0.5), (0.6, 0.5))
"""Speed and torque over rated of the ripple between samples."""


def compare(motor: Motor, name: str, size: int, seed: int, policy: str) -> dict[str, Any]:
    """One policy on one suite: both models, and the carrier's minus the averaged one's."""
    scenarios = suite(name, motor, seed, size)
    rule = make_policy(policy, motor)
    scores = [
        score(rule, scenarios, SimFactory(motor, DriveDesign(estimator="smo", carrier=carrier)))
        for carrier in (False, True)
    ]
    mean, switched = scores
    pair = paired(switched.lost, switched.metrics, mean.lost, mean.metrics, seed)
    return {
        "averaged": chosen(summary(mean.lost, mean.metrics, seed)),
        "carrier": chosen(summary(switched.lost, switched.metrics, seed)),
        "difference": chosen(pair),
    }


def chosen(values: dict[str, Any]) -> dict[str, Any]:
    """The metrics of the study with their intervals, and the counts."""
    names = [*COLUMNS, *(f"{name}_ci" for name in COLUMNS), "lost_ci"]
    counts = {name: x for name, x in values.items() if isinstance(x, int)}
    return {name: np.round(values[name], 6).tolist() for name in names if name in values} | counts


def between_samples(motor: Motor, speed: float, load: float) -> dict[str, float]:
    """Ripple of current and torque within the periods of one turn at a share of rated speed, load.

    The machine is held at its speed on the point of maximum torque per ampere; the voltage is what
    keeps it there, so the samples stand still and what moves is the carrier's.
    """
    line = mtpa(motor)
    tau = torque(motor, line)
    i = np.array([np.interp(load * motor.tau_rated, tau, line[:, j]) for j in range(2)])
    psi = flux(motor.saturation, i[None])[0]
    omega = speed * motor.omega_rated
    n = max(20, round(2.0 * np.pi / (omega * motor.T_s)))
    middle = omega * motor.T_s * (np.arange(n) + 0.5)
    half = 0.5 * omega * motor.T_s
    emf = 1j * omega * complex(*psi) * half / np.sin(half)
    u = (emf + motor.R_s * complex(*i)) * np.exp(1j * middle)
    plant, state = plant_record(motor).reshape(1), np.zeros(1, dtype=PLANT_STATE)
    sensor = sensor_record(motor).reshape(1)
    sensor["dead_time_share"] = 0.0
    plant["inv_J"] = 0.0
    plant["n_sub"], plant["h"] = 4, motor.T_s / 4
    state["psi_d"], state["psi_q"] = psi
    state["omega_m"] = omega / motor.n_p
    inputs = np.stack([u.real, u.imag, np.full(n, motor.u_dc), np.zeros(n)], axis=-1)
    rows = dict(zip(CARRIER_NAMES, carrier_run(sensor, plant, state, inputs).T, strict=True))
    swing = np.hypot(rows["i_d"] - i[0], rows["i_q"] - i[1])
    k = np.rint(rows["t"] / motor.T_s)
    sampled = np.abs(rows["t"] / motor.T_s - k) < 1e-6
    found = {
        "speed_rpm": speed * motor.n_rated_rpm,
        "torque_Nm": load * motor.tau_rated,
        "current_pp_mA": 1e3 * np.hypot(np.ptp(rows["i_d"]), np.ptp(rows["i_q"])),
        "current_off_the_sample_max_mA": 1e3 * np.max(swing),
        "current_sampled_max_mA": 1e3 * np.max(swing[sampled]),
        "torque_pp_pct": 100.0 * np.ptp(rows["tau"]) / motor.tau_rated,
    }
    return {name: round(float(x), 3) for name, x in found.items()}


def table(name: str, found: dict[str, Any]) -> Table:
    """Averaged and carrier side by side."""
    out = Table(title=f"{name}: averaged → carrier")
    out.add_column("policy")
    for heading, _ in COLUMNS.values():
        out.add_column(heading, justify="right")
    for policy, entry in found.items():
        cells = (
            f"{factor * entry['averaged'][key]:.2f} → {factor * entry['carrier'][key]:.2f}"
            for key, (_, factor) in COLUMNS.items()
        )
        out.add_row(policy, *cells)
    return out


def main() -> None:
    """Run the study."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--motor", default="paper")
    parser.add_argument("--seed", type=a_seed, default=1)
    parser.add_argument("--out", type=Path, default=Path("results/studies"))
    args = parser.parse_args()
    folder = ensure_writable(args.out)
    motor, console = Motor.load(args.motor), Console(width=150)
    found: dict[str, Any] = {}
    for name, size in SUITES.items():
        found[name] = {p: compare(motor, name, size, args.seed, p) for p in POLICIES}
        console.print(table(name, found[name]))
    results = {
        "command": f"python studies/carrier_study.py --motor {args.motor} --seed {args.seed}",
        "motor": motor.name,
        "motor_digest": motor.digest,
        "seed": args.seed,
        "sizes": SUITES,
        "versions": versions(),
        "suites": found,
        "between_samples": [between_samples(motor, *point) for point in POINTS],
    }
    write_record(folder / "carrier.json", results)
    console.print(f"wrote {folder / 'carrier.json'}")


if __name__ == "__main__":
    in_one_line(main)
