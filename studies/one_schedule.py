"""One schedule for all machines: a ramp with gains over the speed, tuned on random machines.

    python studies/one_schedule.py

Tunes a ramp on each of some machines, as `sensorless tune linear` does, and then searches one table
for all of them by CMA-ES: where k_s begins to fall and ends, and four gains at three speeds. What
it minimises is how far the table's torque deviation and ripple on a machine exceed those of the
machine's own ramp. Judge it by studies/zero_shot.py, on machines that neither has seen. With
--publish it ships as ``tuned-coupled-machines``.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sensorless.agents.train.config import TrainConfig
from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.carried import record
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.machine_family import family
from sensorless.envs.scenarios.machines import Machines
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import in_one_line
from sensorless.evaluation.engines.threads import LOCAL
from sensorless.evaluation.metrics.catalogue import torque_dev_rms
from sensorless.evaluation.metrics.ripple import torque_ripple_rms
from sensorless.evaluation.rollout import rollout
from sensorless.files import ensure_writable
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policies.shipped import learned_file
from sensorless.policy import Policy, TablePolicy
from sensorless.table.ks_table import Axis, GainGrid, KsTable
from sensorless.tuning.batch import SideBySide
from sensorless.tuning.evolution import evolution
from sensorless.tuning.tune import tune

AXIS = Axis("speed", 0.0, 0.6, 31)
BEGIN, WIDTH = (0.0, 0.15), (0.02, 0.35)
"""Bounds of the speed at which the ramp begins, and of its width, over rated."""
RANGES = TrainConfig(
    gains="observer:0.7:1.4,injection:0.3:1.5,l_q:0.93:1.08,amplitude:0.5:1"
).gain_ranges
SPEEDS = (0.05, 0.2, 0.6)
"""Speeds [rated] between which a gain is linear."""
AS_GOOD, SOFT, TREND, LOSS = 0.01, 0.008, 0.1, 3.0
"""Excess that counts as none; width of that bend; weights of the mean excess and of the losses."""
SIGMA, SAME, CHECK = 0.1, 3, 6
"""First step of the search; generations on the same scenarios, and between two judgements."""
Floats = NDArray[np.float64]


def table_of(x: Floats) -> KsTable:
    """Table of a point in the unit cube: begin and width of the ramp, then the gains' values."""
    speed = AXIS.nodes.astype(np.float64)
    begin, width = (a + (b - a) * y for (a, b), y in zip((BEGIN, WIDTH), x[:2], strict=True))
    k_s = np.clip((begin + width - speed) / width, 0.0, 1.0)
    grids = []
    for (name, gain), y in zip(RANGES.items(), x[2:].reshape(-1, len(SPEEDS)), strict=True):
        limits = gain.limits(1.0)
        values = limits["least"] + (limits["most"] - limits["least"]) * y
        nodes = np.interp(speed, SPEEDS, values).astype(np.float32)
        grids.append(GainGrid(name, nodes, gain.low, gain.high))
    return KsTable((AXIS,), k_s.astype(np.float32), gains=tuple(grids))


def own_ramp(motor: Motor, budget: float) -> str:
    """Word of the ramp that is tuned for a machine."""
    return str(tune("linear", motor, DriveDesign(), budget, 1).provenance["policy"])


def run(policies: Sequence[Policy], motor: Motor, seed: int, size: int) -> Floats:
    """Lost, deviation and ripple of each policy in each scenario, (3, policies, scenarios)."""
    scenarios = SuiteRows("stress-1", motor, seed, size, "tune").draw()
    rows = np.tile(np.arange(size), len(policies))
    r = rollout(SideBySide(policies), scenarios[rows], SimFactory(motor, DriveDesign()))
    lost = (r.lost != 0) & r.feasible
    found = np.stack((lost, torque_dev_rms(r), torque_ripple_rms(r)))
    found[1:, r.lost != 0] = np.nan
    return found.reshape(3, len(policies), size)


def against_own(own: str, motor: Motor, xs: Sequence[Floats], seed: int, size: int) -> Floats:
    """Scenarios lost, and means of deviation and ripple over those of the machine's own ramp."""
    ramp = run([make_policy(own, motor, override=True)], motor, seed, size)
    ours = run([TablePolicy("one", table_of(x)) for x in xs], motor, seed, size)
    both = np.isfinite(ours[1] + ramp[1])
    means = (np.nanmean(np.where(both, y[1:], np.nan), axis=2) for y in (ours, ramp))
    more = np.nan_to_num(next(means) / next(means), nan=2.0)  # where none survives both
    return np.concatenate([ours[:1].sum(axis=2), more]).T


def cost(found: Floats, size: int) -> float:
    """Value of what ``against_own`` finds on all machines, (machines, 3)."""
    more = found[:, 1:] - 1.0
    bend = SOFT * np.logaddexp(0.0, (more - AS_GOOD) / SOFT).mean()
    return float(bend + TREND * more.mean() + LOSS * found[:, 0].sum() / (size * len(found)))


def search(motors: Sequence[Motor], words: argparse.Namespace) -> KsTable:
    """Best of the judged centres."""
    es = evolution([0.4] * 2 + [0.5] * (len(RANGES) * len(SPEEDS)), SIGMA, words.seed)
    best, least = np.array(es.x0), np.inf
    own = list(LOCAL.map(lambda motor: own_ramp(motor, words.budget), motors))

    def found(xs: Sequence[Floats], seed: int, size: int) -> Floats:
        jobs = zip(own, motors, strict=True)
        parts = LOCAL.map(lambda job: against_own(*job, xs, seed, size), jobs)
        return np.stack(list(parts), axis=1)

    for generation in range(words.generations):
        points = [np.array(x) for x in es.ask()]
        drawn = int(combine(words.seed, generation // SAME)[0]) >> 1
        es.tell(points, [cost(f, words.size) for f in found(points, drawn, words.size)])
        if generation % CHECK == CHECK - 1 or generation == words.generations - 1:
            centre = np.clip(es.result.xfavorite, 0.0, 1.0)
            judged = found([centre], words.seed, 4 * words.size)[0]
            value = cost(judged, 4 * words.size)
            dev, ripple = (judged[:, 1:] <= 1.0 + 2.0 * AS_GOOD).mean(axis=0)
            lost = judged[:, 0].sum()
            print(f"{generation + 1}: {value:.5f}, lost {lost:.0f}; within 2 %: deviation on "
                  f"{dev:.0%}, ripple on {ripple:.0%}", flush=True)  # fmt: skip
            if value < least:
                best, least = centre, value
    return table_of(best)


def main() -> None:
    """Search, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--machines", type=a_count, default=32)
    parser.add_argument("--budget", type=float, default=8000.0, help="simulated s for each ramp")
    parser.add_argument("--generations", type=a_count, default=42)
    parser.add_argument(
        "--size", type=a_count, default=24, help="scenarios of a machine a generation"
    )
    parser.add_argument("--seed", type=a_seed, default=7, help="of machines, scenarios and search")
    parser.add_argument("--out", type=Path, default=Path("build/one-schedule.json"))
    parser.add_argument("--publish", action="store_true", help="ship it by its name")
    words = parser.parse_args()
    out = learned_file("tuned-coupled-machines") if words.publish else words.out
    ensure_writable(out.parent)
    motors = family(words.seed, words.machines)
    table = search(motors, words)
    facts = {"command": f"python studies/one_schedule.py --seed {words.seed} --machines "
             f"{words.machines} --budget {words.budget:g} --generations {words.generations} "
             f"--size {words.size}"}  # fmt: skip
    origin = {**Machines(motors, words.seed).origin(), **record(DriveDesign())}
    table.save(out, {**origin, **facts})
    print(f"wrote {out}")


if __name__ == "__main__":
    in_one_line(main)
