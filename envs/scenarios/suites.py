"""Suites: named sets of scenarios, each a function of name, seed and size alone.

A scenario depends on these and on its own index only, so any part of a suite can be drawn anywhere.
"""

import dataclasses
from collections.abc import Callable
from numbers import Integral

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Seeds, check_seed, combine
from sensorless.envs.scenarios.envelope import envelope_scenarios
from sensorless.envs.scenarios.finds import hard_scenarios
from sensorless.envs.scenarios.handoff import handoff_scenarios
from sensorless.envs.scenarios.load_steps import (
    impact_scenarios,
    stop_scenarios,
    unload_scenarios,
)
from sensorless.envs.scenarios.low_speed import braking_scenarios, crawl_scenarios, hold_scenarios
from sensorless.envs.scenarios.published import paper_scenarios
from sensorless.envs.scenarios.reversal import reversal_scenarios
from sensorless.envs.scenarios.sag import sag_scenarios
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.starts import starts_scenarios
from sensorless.envs.scenarios.stress import (
    low_inertia_scenarios,
    mismatch_scenarios,
    nominal_scenarios,
    stress_1_scenarios,
    stress_scenarios,
)
from sensorless.errors import UserError, like, shown
from sensorless.machine.motor import Motor

ROLES = {"train": 1, "tune": 2, "test": 3}
"""Keeps the seeds of training, tuning and judging apart."""
MOST_SCENARIOS = 10_000_000
"""Of a suite."""
REPEATS = 10_000
"""Indices from here on repeat what a suite was searched for, with every number moved."""

Indices = NDArray[np.int64]


@dataclasses.dataclass(frozen=True)
class SuiteRows:
    """Scenarios of a suite that are not drawn yet: a few numbers, however large the suite.

    Parameters
    ----------
    name : str
        One of ``SUITES``.
    motor : Motor
    suite_seed : int
        0 to 2^63 - 1; another seed draws other scenarios.
    size : int
        Number of scenarios in the suite; a square number for ``envelope``, which is a grid.
    role : str
        ``train``, ``tune`` or ``test``; different roles never share a scenario.
    rows : range, optional
        Indices of the scenarios; default: all.

    Raises
    ------
    UserError
        Unknown suite or role, or a seed or size out of range.
    """

    name: str
    motor: Motor
    suite_seed: int
    size: int
    role: str = "test"
    rows: range | None = None

    def __post_init__(self) -> None:
        name, seed, size = self.name, self.suite_seed, self.size
        if name not in SUITES:
            raise UserError(
                f"suite: {name!r} does not exist; {like(name, SUITES)}choose from "
                f"{', '.join(SUITES)}; simulate, evaluate, report, certify and falsify also know "
                "machines"
            )
        if self.role not in ROLES:
            raise UserError(f"role: {self.role!r} does not exist; choose from {', '.join(ROLES)}")
        check_seed(seed)
        if not isinstance(size, Integral) or not 1 <= size <= MOST_SCENARIOS:
            raise UserError(f"size: {shown(size)}; give 1 to {MOST_SCENARIOS} scenarios")
        if name == "envelope" and (size < 4 or int(np.sqrt(size)) ** 2 != size):
            raise UserError(f"size: {size}; envelope is a grid: give a square number, at least 4")

    def __len__(self) -> int:
        """Return the number of scenarios."""
        return len(self._range)

    def __getitem__(self, rows: slice) -> "SuiteRows":
        """Return some of the scenarios."""
        return dataclasses.replace(self, rows=self._range[rows])

    @property
    def _range(self) -> range:
        return range(self.size) if self.rows is None else self.rows

    @property
    def seed(self) -> Seeds:
        """(n,) seeds of the scenarios."""
        return combine(ROLES[self.role], self.suite_seed, np.asarray(self._range))

    def draw(self) -> Scenarios:
        """Draw the scenarios."""
        return SUITES[self.name](self.motor, self.seed, np.asarray(self._range), self.size)


def motors_scenarios(motor: Motor, seeds: Seeds, indices: Indices, size: int) -> Scenarios:
    """``handoff`` (even rows) and ``stress-1`` (odd rows), for machines that training never saw.

    Every scenario is relative to the machine's own numbers: run the suite once for each shipped
    machine except the one that was trained on.
    """
    s = stress_1_scenarios(motor, seeds)
    even = indices % 2 == 0
    crossings = handoff_scenarios(motor, seeds[even], indices[even] // 2, size)
    for f in dataclasses.fields(s):
        rows = np.array(getattr(s, f.name))
        rows[even] = getattr(crossings, f.name)
        setattr(s, f.name, rows)
    return s


SUITES: dict[str, Callable[[Motor, Seeds, Indices, int], Scenarios]] = {
    "paper": paper_scenarios,
    "nominal": nominal_scenarios,
    "handoff": handoff_scenarios,
    "stress": lambda motor, seeds, *_: stress_scenarios(motor, seeds),
    "stress-1": lambda motor, seeds, *_: stress_1_scenarios(motor, seeds),
    "mismatch": lambda motor, seeds, *_: mismatch_scenarios(motor, seeds),
    "low-inertia": lambda motor, seeds, *_: low_inertia_scenarios(motor, seeds),
    "hard": lambda motor, seeds, indices, _: hard_scenarios(motor, seeds, indices, 0),
    "hard-train": lambda motor, seeds, indices, _: hard_scenarios(motor, seeds, indices, 1),
    "hold": hold_scenarios,
    "crawl": crawl_scenarios,
    "impact": impact_scenarios,
    "stop": stop_scenarios,
    "unload": unload_scenarios,
    "braking": braking_scenarios,
    "sag": sag_scenarios,
    "reversal": reversal_scenarios,
    "envelope": envelope_scenarios,
    "motors": motors_scenarios,
    "starts": starts_scenarios,
}
"""Functions of motor, seeds (n,), indices (n,) and the suite's size that draw n scenarios."""


def suite(name: str, motor: Motor, seed: int, size: int, role: str = "test") -> Scenarios:
    """All scenarios of a suite; arguments and errors as in ``SuiteRows``."""
    return SuiteRows(name, motor, seed, size, role).draw()


def scenario_word(name: str, seed: int, index: int, size: int) -> str:
    """Return SUITE:SEED:INDEX[:SIZE], which names a scenario for ``sensorless simulate``.

    The size stands only where a scenario depends on it: in the grid of ``envelope``.
    """
    return f"{name}:{seed}:{index}" + (f":{size}" if name == "envelope" else "")


def sampler(name: str) -> Callable[[Motor, Seeds], Scenarios]:
    """Endless stream of the scenarios of a suite: a function of motor and seeds (n,) that draws n.

    Each follows from its seed alone. Suites with a plan take a step of it by chance, and ``hard``
    moves every number, as in its repeats.

    Raises
    ------
    UserError
        There is no such suite, or it is a grid, which has no stream.
    """
    known = [suite for suite in SUITES if suite != "envelope"]
    if name not in known:
        raise UserError(f"scenarios: {name!r}; choose from {', '.join(known)}, or give a function")

    def draw(motor: Motor, seeds: Seeds) -> Scenarios:
        indices = REPEATS + (seeds >> np.uint64(34)).astype(np.int64)
        return SUITES[name](motor, seeds, indices, len(seeds))

    return draw
