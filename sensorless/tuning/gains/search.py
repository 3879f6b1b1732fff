"""Gains of a drive by CMA-ES, as factors on those that it starts from.

Each generation draws scenarios of its own, the same for its candidates and for the start, which is
their yardstick. After every CHECK generations the centre of the search is judged on a fixed larger
set; the result is the centre with the least objective that keeps what the start keeps, or the
start if there is none.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import check_seed, combine
from sensorless.envs.scenarios.suites import suite
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.policy import Policy
from sensorless.tuning.evolution import evolution
from sensorless.tuning.gains.choice import Gain, Gains, decode, with_gains
from sensorless.tuning.gains.measure import Measured, cost, excess, joined, measure

SUITES = {"stress-1": 0.75, "nominal": 0.25}
"""Suites of the scenarios, and their shares: most on drives that do not know their machine."""
ROLE = "tune"
SIGMA = 0.15
"""First step of the search: 15 % of every gain."""
MARGIN = 0.002
"""What the search wants of everything that has to be kept, so that it is kept elsewhere too."""
CHECK = 3
"""Generations between two judgements of the centre."""
JUDGED = 4
"""Scenarios that a centre is judged on, over those of a candidate."""

Progress = Callable[[float, float, float], None]
"""Called with the share done, and the objectives of the best found so far and of the start."""


@dataclass(frozen=True)
class Centre:
    """A centre of the search, judged."""

    objective: float
    unkept: float
    """``excess`` over the start"""
    gains: Gains


@dataclass
class Search:
    """Result of a search, and its state on the way."""

    gains: Sequence[Gain]
    best: Gains = field(default_factory=dict)
    """Empty: the start."""
    best_value: float = np.inf
    start_value: float = np.inf
    tried: int = 0
    population: int = 0
    centres: list[Centre] = field(default_factory=list)
    """Every centre judged."""
    interrupted: bool = False


def search(
    motor: Motor,
    design: DriveDesign,
    policy: Policy,
    gains: Sequence[Gain],
    *,
    evaluations: int,
    size: int,
    seed: int,
    progress: Progress | None = None,
) -> Search:
    """Tune gains of a design; the same arguments give the same result.

    Parameters
    ----------
    policy : Policy
        Chooses k_s; brings no settings of its own.
    evaluations : int
        Sets of gains to try, rounded down to whole generations.
    size : int
        Scenarios that each set runs.
    seed : int
        Seed of the scenarios and of the search.

    Raises
    ------
    UserError
        Evaluations, scenarios or seed out of range, or the library cma is missing.
    KeyboardInterrupt
        Before the start has been judged; later, an interrupt ends the search with its best.
    """
    lows, highs = [g.low for g in gains], [g.high for g in gains]
    es = evolution(_inside(lows, highs), SIGMA, seed, lows, highs)
    if not es.popsize <= evaluations <= 1_000_000:
        raise UserError(f"evaluations: {evaluations}; give {es.popsize} to 1000000")
    if not 8 <= size <= 100_000:
        raise UserError(f"size: {size}; give 8 to 100000 scenarios")
    check_seed(seed)

    def run(values: Gains, generation: int, n: int) -> Measured:
        draw = int(combine(seed, generation)[0]) >> 1
        drive = with_gains(design, values)
        return joined(
            [
                measure(motor, drive, policy, suite(name, motor, draw, round(share * n), ROLE))
                for name, share in SUITES.items()
            ]
        )

    known = Search(gains, population=es.popsize)
    start = run({}, 0, JUDGED * size)
    known.start_value = known.best_value = cost(start, start).objective
    generations = evaluations // es.popsize
    try:
        for g in range(1, generations + 1):
            yardstick, points, values = run({}, g, size), es.ask(), []
            for x in points:
                found = run(decode(gains, x), g, size)
                price = excess(found, yardstick, MARGIN)
                values.append(cost(found, yardstick).objective + price)
                known.tried += 1
                if progress is not None:
                    share = known.tried / (generations * es.popsize)
                    progress(share, known.best_value, known.start_value)
            es.tell(points, values)
            end = g == generations or bool(es.stop())
            if end or g % CHECK == 0:
                centre = decode(gains, es.result.xfavorite)
                judge(known, centre, run(centre, 0, JUDGED * size), start)
            if end:
                break
    except KeyboardInterrupt:
        known.interrupted = True
    return known


def judge(known: Search, values: Gains, found: Measured, start: Measured) -> None:
    """Keep these gains if they cost less than the best so far and keep what the start keeps."""
    value, lacking = cost(found, start).objective, excess(found, start)
    known.centres.append(Centre(value, lacking, values))
    if value < known.best_value and lacking == 0.0:
        known.best, known.best_value = values, value


def _inside(lows: Sequence[float], highs: Sequence[float]) -> list[float]:
    """The start, a factor of one, or a little less where that is a bound."""
    return [min(max(0.0, low + 0.02), high - 0.02) for low, high in zip(lows, highs, strict=True)]
