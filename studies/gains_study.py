"""The drive's own gains by CMA-ES, so that Eq. 25 is as good as it can be before learning.

Usage: python studies/gains_study.py [--generations N] [--out results/studies/gains.json]

Bandwidths, slopes, the current limit and the biases of the observers are searched on scenarios of
`stress` and `nominal` from the tuning seeds; each generation has scenarios of its own, the same for
all candidates. A slow speed loop is always easier to keep in lock, so a drive that follows its
speed reference less closely than the start is penalised. The start and every PROBE-th centre are
judged on a separate set; so are, at the end, the shipped gains, and the start with each gain of the
best alone. The file is written after every generation: rerun the command to resume.
"""

import argparse
import dataclasses
import json
import math
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import cma
import numpy as np

from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.metrics.catalogue import torque_dev_rms
from sensorless.evaluation.metrics.profile import reference
from sensorless.evaluation.metrics.ripple import torque_ripple_rms
from sensorless.evaluation.objective import OBJECTIVE, Cost
from sensorless.evaluation.rollout import rollouts
from sensorless.files import write_atomic
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.versions import versions

RULE = "eq25"
PAPERS = DriveDesign(estimator="smo")
"""The drive with the paper's observers, whose gains these are."""
SEED = 1
SIGMA = 0.15
POPULATION = 12
PROBE = 5
SLOW = 10.0
"""Weight of the RMS distance to the speed reference, over rated speed, beyond the start's."""
SIZES = {"stress-1": 192, "nominal": 64}
JUDGED = {"stress-1": 768, "nominal": 256}
GAINS: dict[str, tuple[float, float, bool]] = {
    "hfi_pll_hz": (6.0, 50.0, True),
    "smo_pll_hz": (6.0, 60.0, True),
    "smo_gain": (0.2, 1.6, False),
    "smo_cross_hz": (3.0, 300.0, True),
    "L_q_bias": (0.5, 1.1, False),
    "speed_hz": (1.0, 6.0, True),
    "current_hz": (50.0, 300.0, True),
    "i_q_slew": (30.0, 1500.0, True),
    "k_s_slew": (5.0, 500.0, True),
    "dead_time_share": (0.3, 1.0, False),
    "i_max": (6.7, 12.6, False),
}
"""Lowest and highest value, and whether the scale is logarithmic; i_max in A."""

Values = dict[str, float]
Record = dict[str, Any]

START: Values = {
    "hfi_pll_hz": 17.0, "smo_pll_hz": 20.0, "smo_gain": 1.0, "smo_cross_hz": 20.0,
    "L_q_bias": 0.8, "speed_hz": 2.5, "current_hz": 120.0, "i_q_slew": 150.0, "k_s_slew": 50.0,
    "dead_time_share": 0.75, "i_max": 8.4,
}  # fmt: skip
"""Gains set by hand."""


def cost(values: Values, motor: Motor, seed: int, sizes: dict[str, int]) -> dict[str, float]:
    """What Eq. 25 costs on a drive with these gains, by suite.

    ``speed_off`` is the mean RMS of (speed reference - speed) / rated speed of the drives that
    survive: their sensored twins are as slow as they are and do not tell.
    """
    gains = dict(values)
    machine = dataclasses.replace(motor, i_max=gains.pop("i_max"))
    factory = SimFactory(machine, dataclasses.replace(PAPERS, **gains))  # type: ignore[arg-type]
    policy = make_policy(RULE, machine)
    found: dict[str, float] = {}
    for name, size in sizes.items():
        alive, dev, ripple, off = [], [], [], []
        for r in rollouts(policy, suite(name, motor, seed, size, "tune"), factory):
            alive.append(r.lost == 0)
            dev.append(torque_dev_rms(r))
            ripple.append(torque_ripple_rms(r))
            speed = (reference(r) - r.mean("omega_m")) * motor.n_p / motor.omega_rated
            off.append(np.sqrt(np.nanmean(speed**2, axis=0)))
        kept = np.concatenate(alive)
        means = [float(np.concatenate(x)[kept].mean()) if kept.any() else 1.0
                 for x in (dev, ripple, off)]  # fmt: skip
        one = Cost(float(np.mean(~kept)), means[0], means[1])
        found |= {f"{name}_{k}": v for k, v in dataclasses.asdict(one).items()}
        found[f"{name}_speed_off"] = means[2]
        found[f"{name}_objective"] = one.objective
    return found


def value(found: dict[str, float], start: dict[str, float]) -> float:
    """The number that is made least: OBJECTIVE of all suites, and SLOW for a slower response."""
    return sum(
        found[f"{n}_objective"] + SLOW * max(0.0, found[f"{n}_speed_off"] - start[f"{n}_speed_off"])
        for n in SIZES
    )


def decode(x: Sequence[float]) -> Values:
    """Gains of a point of the unit cube."""
    values = {}
    for u, (name, (low, high, log)) in zip(np.clip(x, 0.0, 1.0), GAINS.items(), strict=True):
        y = low * (high / low) ** u if log else low + u * (high - low)
        values[name] = float(f"{y:.4g}")
    return values


def encode(values: Values) -> list[float]:
    """Point of the unit cube of these gains."""
    return [
        math.log(values[n] / lo) / math.log(hi / lo) if log else (values[n] - lo) / (hi - lo)
        for n, (lo, hi, log) in GAINS.items()
    ]


def main() -> None:
    """Search and record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--generations", type=int, default=30)
    parser.add_argument("--out", type=Path, default=Path("results/studies/gains.json"))
    options = parser.parse_args()
    motor = Motor.load("paper")
    rng = np.random.default_rng(SEED)
    es = cma.CMAEvolutionStrategy(
        encode(START), SIGMA,
        {"bounds": [0.0, 1.0], "popsize": POPULATION, "verbose": -9, "verb_log": 0, "seed": np.nan,
         "randn": lambda rows, columns: rng.standard_normal((rows, columns))},
    )  # fmt: skip
    known = json.loads(options.out.read_text()) if options.out.exists() else {}
    if known and known["start"] != START:
        sys.exit(f"{options.out} belongs to another start; give another --out")
    record: Record = {
        "command": "python studies/gains_study.py", "rule": RULE, "motor": motor.name,
        "objective": f"sum over suites of {OBJECTIVE} + {SLOW:g} max(0, speed_off - the start's)",
        "sizes": SIZES, "judged_on": JUDGED, "role": "tune", "seed": SEED, "start": START,
        "ranges": GAINS, "versions": versions(),
        "generations": known.get("generations", []), "judged": known.get("judged", []),
    }  # fmt: skip
    done = len(record["generations"])

    def judge(generation: int, values: Values) -> None:
        if any(j["generation"] == generation for j in record["judged"]):
            return
        at: Record = {"generation": generation, "gains": values,
              "cost": cost(values, motor, int(combine(SEED, 0)[0]) >> 1, JUDGED)}  # fmt: skip
        at["value"] = value(at["cost"], record["judged"][0]["cost"] if generation else at["cost"])
        record["judged"].append(at)
        print(f"judged after {generation}: {at['value']:.4f} {values}", flush=True)

    judge(0, START)
    for g in range(1, options.generations + 1):
        points = es.ask()
        began = time.monotonic()
        if g <= done:
            costs = record["generations"][g - 1]["objectives"]
        else:
            draw = int(combine(SEED, g)[0]) >> 1
            base = cost(START, motor, draw, SIZES)
            costs = [value(cost(decode(x), motor, draw, SIZES), base) for x in points]
            record["generations"].append({"objectives": costs})
        es.tell(points, costs)
        if g % PROBE == 0 or g == options.generations:
            judge(g, decode(es.result.xfavorite))
        record["best"] = min(record["judged"], key=lambda j: j["value"])
        if g > done:
            options.out.parent.mkdir(parents=True, exist_ok=True)
            write_atomic(options.out, json.dumps(record, indent=1) + "\n")
            print(f"generation {g}: best of it {min(costs):.4f}, median "
                  f"{float(np.median(costs)):.4f}, {time.monotonic() - began:.0f} s",
                  flush=True)  # fmt: skip
    best = record["best"]["gains"]
    base, draw = record["judged"][0]["cost"], int(combine(SEED, 0)[0]) >> 1
    design = dataclasses.asdict(PAPERS)
    shipped = {n: motor.i_max if n == "i_max" else float(design[n]) for n in GAINS}
    trials = {f"start with {n} of the best": {**START, n: best[n]} for n in GAINS}
    record["compared"] = {}
    for name, values in {"shipped": shipped, **trials}.items():
        found = cost(values, motor, draw, JUDGED)
        record["compared"][name] = {"gains": values, "value": value(found, base), "cost": found}
        print(f"{name}: {value(found, base):.4f}", flush=True)
    write_atomic(options.out, json.dumps(record, indent=1) + "\n")
    print(f"wrote {options.out}")


if __name__ == "__main__":
    main()
