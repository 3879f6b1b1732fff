"""Logistic rule with gains of the drive, static or over speed, tuned together by CMA-ES.

The strongest opponent of a schedule that learns gains: it may set the same ones in the same ranges.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from sensorless.baselines.logistic import RULE, logistic_table
from sensorless.core.gains import GAIN_NAMES, Gain
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import Axis, GainGrid, KsTable
from sensorless.tuning.batch import costs
from sensorless.tuning.evolution import evolution

AXES = (
    Axis("speed", 0.0, 1.0, 17),
    Axis("torque_current", -1.5, 1.5, 5),
    Axis("disagreement", -1.0, 1.0, 3),
)
"""Grid of k_s and gains: the finest of three axes in which four gains have room."""
STATIC, SCHEDULED = (0.0,), (0.1, 0.25, 0.5, 0.8)
"""Speeds [rated] between which a gain is linear, constant outside."""
SIGMA = 0.12
"""First step of the search, over the range of each number."""
CANDIDATE, CHECK, JUDGED = 32, 6, 1024
"""Scenarios of a candidate, generations between two judgements, scenarios of a judgement."""
LOST_BESIDE = 0.1
"""Weight of the share lost on suites in which many are: losing one in ten of them more weighs like
1 % of torque."""

Floats = NDArray[np.float64]


def table_of(x: Floats, ranges: Mapping[str, Gain], speeds: Sequence[float]) -> KsTable:
    """Table of a point in the unit cube: the rule's numbers, then each gain at each speed."""
    n = len(RULE.parameters)
    values = {
        p.name: p.search[0] + (p.search[1] - p.search[0]) * float(y)
        for p, y in zip(RULE.parameters, x[:n], strict=True)
    }
    at = np.broadcast_to(AXES[0].nodes[:, None, None], [a.n for a in AXES])
    names = [name for name in GAIN_NAMES if name in ranges]
    grids = []
    for name, y in zip(names, x[n:].reshape(-1, len(speeds)), strict=True):
        limits = ranges[name].limits(1.0)
        wanted = np.clip(2.0 * y - 1.0, limits["least"], limits["most"])
        nodes = np.interp(at, speeds, wanted).astype(np.float32)
        grids.append(GainGrid(name, nodes, ranges[name].low, ranges[name].high))
    return KsTable(AXES, logistic_table(values, AXES).values, gains=tuple(grids))


def tune_with_gains(
    factory: SimFactory,
    ranges: Mapping[str, Gain],
    speeds: Sequence[float],
    budget: float,
    seed: int,
    ripple_weight: float,
    start: Mapping[str, float],
    beside: Sequence[str] = (),
) -> tuple[KsTable, float]:
    """Best centre of the search within ``budget`` simulated seconds, and its value in judgement.

    Parameters
    ----------
    start : mapping
        The rule's numbers to begin with; all gains begin static.
    beside : sequence of str
        Suites of which the share lost counts too, with ``LOST_BESIDE``.
    """
    motor = factory.motor
    first = [
        float(np.clip((start[p.name] - p.search[0]) / (p.search[1] - p.search[0]), 0.02, 0.98))
        for p in RULE.parameters
    ]
    es = evolution(first + [0.5] * (len(ranges) * len(speeds)), SIGMA, seed)

    def values(tables: Sequence[KsTable], draw: int, size: int) -> tuple[Floats, float]:
        """Value of each table on scenarios of this seed, and the simulated seconds."""
        policies = [TablePolicy("tried", table) for table in tables]
        found, seconds = costs(policies, suite("stress-1", motor, draw, size, "tune"), factory)
        out = np.array([cost.weighted(ripple_weight) for cost in found])
        for name in beside:
            found, more = costs(policies, suite(name, motor, draw, size, "tune"), factory)
            out += LOST_BESIDE * np.array([cost.lost_rate for cost in found])
            seconds += more
        return out, seconds

    best, least, used = table_of(np.array(es.x0), ranges, speeds), np.inf, 0.0
    generation = 0
    while used < budget:
        points = es.ask()
        draw = int(combine(seed, generation)[0]) >> 1
        found, seconds = values([table_of(x, ranges, speeds) for x in points], draw, CANDIDATE)
        es.tell(points, list(found))
        used += seconds
        generation += 1
        if generation % CHECK == 0 or used >= budget:
            centre = table_of(np.array(es.result.xfavorite), ranges, speeds)
            (value,), seconds = values([centre], seed, JUDGED)
            used += seconds
            if value < least:
                best, least = centre, float(value)
    return best, least
