"""Turns a network, or another policy without memory, into a table, as DAgger does.

The table is fitted on the states that it visits itself.

The first round runs the network and fits a table to its decisions. Every later round runs the last
table on new scenarios, asks the network what it would have decided there, and fits a table to all
samples so far (Ross et al. 2011, arXiv 1011.0686).
"""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.agents.table.fit import TableFit
from sensorless.core.api import Array
from sensorless.core.runs import running
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import suite
from sensorless.envs.signals import HIGH, LOW
from sensorless.errors import UserError
from sensorless.evaluation.objective import Cost
from sensorless.evaluation.rollout import rollouts
from sensorless.evaluation.validation import SUITE, validate
from sensorless.policy import Policy, Signals, TablePolicy
from sensorless.table.ks_table import Axis, KsTable

STRIDE = 5
"""Decisions between two samples of a drive."""

PROBES = 33
"""Drives with which a teacher is tried for a memory, from the least signals to the largest."""

Progress = Callable[[int, float, Cost], None]
"""Called after a round with its number, the RMS difference of k_s and the table's cost."""


@dataclass(frozen=True)
class Distilled:
    """A table, and how far it falls short of the network."""

    table: KsTable
    rms: float
    """RMS difference between the table's k_s and the network's, in states that the table visits in
    scenarios it was not fitted on."""
    network: Cost
    cost: Cost
    """Cost of the table; both costs on the scenarios of validation."""

    def facts(self) -> dict[str, Any]:
        """Fidelity as JSON types."""
        return {
            "k_s_rms": self.rms,
            "network_validation": asdict(self.network),
            "validation": asdict(self.cost),
        }


class _Taught:
    """Runs one policy and asks the teacher what it would decide in the same states."""

    sensored = False

    def __init__(self, policy: Policy, teacher: Policy, fit: TableFit) -> None:
        self.name, self._policy, self._teacher, self._fit = policy.name, policy, teacher, fit
        self.settings = teacher.settings
        self._count, self._sum, self._n = 0, 0.0, 0

    def reset(self, n: int) -> None:
        """Restart policy and sampling."""
        self._policy.reset(n)
        self._count = 0

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights of the policy."""
        return self._policy.act(obs)

    def act_knowing(self, obs: Signals, sims: Array) -> NDArray[np.float32]:
        """Weights of the policy; ``sims`` only serves to leave out drives at their end."""
        k_s = self._policy.act(obs)
        if self._count % STRIDE == 0:
            rows = running(sims) & np.isfinite(obs).all(axis=1)
            wanted = self._teacher.act(obs[rows])
            self._fit.add(obs[rows], wanted)
            self._sum += float(np.sum(np.square(k_s[rows] - wanted, dtype=np.float64)))
            self._n += len(wanted)
        self._count += 1
        return k_s

    @property
    def rms(self) -> float:
        """RMS difference to the teacher over all samples."""
        return float(np.sqrt(self._sum / max(self._n, 1)))


def distill(
    teacher: Policy,
    axes: tuple[Axis, ...],
    factory: SimFactory,
    *,
    rounds: int,
    size: int,
    seed: int,
    smoothness: float,
    validate_size: int,
    report: Progress | None = None,
) -> Distilled:
    """Fit a table to a network; the same arguments give the same table.

    Parameters
    ----------
    teacher : Policy
        It must have no memory, see ``refuse_memory``, and set k_s alone.
    axes : tuple of Axis
        Axes of the table.
    factory : SimFactory
        Machine and design.
    rounds : int
        Number of fits; the table that validates best is kept.
    size : int
        Stress scenarios per round, role ``train``.
    smoothness : float
        See ``TableFit``.
    validate_size : int
        Stress scenarios on which network and tables are judged, role ``tune``.
    """
    fit = TableFit(axes, smoothness)
    running: Policy = teacher
    best: Distilled | None = None
    judged = validate(teacher, factory, validate_size)
    _visit(running, teacher, fit, factory, seed, 0, size)
    for j in range(1, rounds + 1):
        table = fit.solve(factory.design.k_s_slew)
        running = TablePolicy("distilled", table, teacher.settings)
        cost = validate(running, factory, validate_size)
        rms = _visit(running, teacher, fit, factory, seed, j, size)
        if best is None or cost.objective < best.cost.objective:
            best = Distilled(table, rms, judged, cost)
        if report is not None:
            report(j, rms, cost)
    assert best is not None
    return best


def _visit(
    policy: Policy,
    teacher: Policy,
    fit: TableFit,
    factory: SimFactory,
    seed: int,
    number: int,
    size: int,
) -> float:
    """Run a policy on the scenarios of a round; return the RMS difference to the teacher."""
    taught = _Taught(policy, teacher, fit)
    drawn = int(combine(seed, number)[0]) >> 1
    for _ in rollouts(taught, suite(SUITE, factory.motor, drawn, size, "train"), factory):
        pass
    return taught.rms


def refuse_memory(teacher: Policy) -> None:
    """Refuse a policy that answers the same signals otherwise after another past.

    Raises
    ------
    UserError
        Names the policy.
    """
    low, high = np.clip(LOW, -1.0, 1.0), np.clip(HIGH, -1.0, 1.0)
    signals = np.linspace(low, high, PROBES, dtype=np.float32)
    answers = []
    for past, decisions in ((low, 3), (high, 20)):
        teacher.reset(PROBES)
        for _ in range(decisions):
            teacher.act(np.tile(past, (PROBES, 1)).astype(np.float32))
        answers.append(teacher.act(signals))
    if np.abs(answers[0] - answers[1]).max() > 1e-5:
        raise UserError(
            f"policy: {teacher.name} answers the same signals with other weights after another "
            "past, which no table can; distill one without memory"
        )
