"""n drives advanced together, decision by decision: what both environments are built on."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sensorless.core.api import (
    SIGNAL_N,
    SIM,
    Array,
    lib,
    sim_run,
    sim_signals,
    sim_start,
    sums_matrix,
    words,
)
from sensorless.core.gains import gain_records, ranks
from sensorless.decision import whole_periods
from sensorless.envs.batch_state import BatchState, checked_state, made_on
from sensorless.envs.blend_settings import BlendSettings, checked_actions
from sensorless.envs.counter_random import Seeds, combine
from sensorless.envs.privileged import FIXED, Values, fixed, privileged
from sensorless.envs.reward import Term, terms, total
from sensorless.envs.scenarios.checked import checked_scenarios
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.signals import Observation, bounded
from sensorless.envs.window_reward import Window, WindowWeights, window_terms
from sensorless.errors import UserError, shown
from sensorless.machine.motor import Motor

Flags = NDArray[np.bool_]
Rows = NDArray[np.intp]

LOST_TWIN: int = lib.LOST_TWIN
"""Bit of ``lost``, see core/sim/sim.h: even the sensored twin tripped, so no policy is to blame."""


@dataclass(frozen=True)
class Outcome:
    """What the last decision brought, each array with n rows."""

    reward: Term
    terms: dict[str, Term]
    lost: Flags
    """Lock was lost: the episode terminated."""
    alarm: Flags
    """The drive's own tests tell lost lock."""
    ended: Flags
    """The scenario is over, or even its sensored twin tripped: the episode is truncated."""


AT_ONCE = 512
"""Drives made or copied at a time, to bound the memory that this takes."""

_BYTES = {name: (f[1], f[1] + f[0].itemsize) for name, f in (SIM.fields or {}).items()}
_GIVEN = np.r_[: -(-_BYTES["drive"][0] // 8), _BYTES["sums"][1] // 8 : SIM.itemsize // 8]
"""Words of SIM that a drive is given before it starts; ``sim_start`` derives the others."""


class Prepared(NamedTuple):
    """Episodes of some drives that are ready to start, one a row."""

    given: Array
    """(n, len(_GIVEN)) those words"""
    constant: Values
    """(n, len(FIXED)) fixed true quantities"""


class BlendBatch:
    """n drives, each with its own endless stream of scenarios.

    Scenario j of drive i is a pure function of (seed of drive i, j), whatever n is.

    Parameters
    ----------
    n : int
    settings : BlendSettings
    """

    def __init__(self, n: int, settings: BlendSettings) -> None:
        motor = settings.motor
        self.motor = motor if isinstance(motor, Motor) else Motor.load(motor)
        self.settings = settings
        self._factory = SimFactory(self.motor, settings.design)
        self.periods = whole_periods(settings.decision_period, self.motor)
        self._seeds: Seeds = np.zeros(n, dtype=np.uint64)
        self._episode: Seeds = np.zeros(n, dtype=np.uint64)
        self._sims = np.zeros(n, dtype=SIM)
        self._signals: Observation = np.zeros((n, SIGNAL_N), dtype=np.float32)
        self._constant: Values = np.zeros((n, len(FIXED)), dtype=np.float32)
        # One prepared episode per drive: drawing scenarios costs as much for one row as for all.
        self._next = Prepared(np.zeros((n, len(_GIVEN)), np.uint64), self._constant.copy())
        self._ready = np.zeros(n, dtype=bool)
        self._sums = self._copied_sums()
        self._decision = self.periods * self.motor.T_s
        # Column of the action that has each gain, in the order in which they come into force.
        names = list(settings.ranges)
        self._columns = [1 + names.index(name) for name in ranks(names)]
        self._gains = gain_records(
            self._sims if self._columns else self._sims[:0], settings.ranges, self._decision
        )
        windowed = isinstance(settings.weights, WindowWeights)
        self._window = Window(n, self._decision) if windowed else None
        self._made = made_on(n, self.motor, settings)

    @property
    def n_actions(self) -> int:
        """Numbers in an action: k_s, then the gains of the settings."""
        return 1 + len(self._columns)

    def __len__(self) -> int:
        """Return the number of drives."""
        return len(self._seeds)

    def seed(self, rows: Rows, seeds: Sequence[int]) -> None:
        """Start the scenario streams of some drives anew."""
        self._seeds[rows] = np.array(seeds, dtype=np.uint64)
        self._episode[rows] = 0
        self._ready[rows] = False

    def begin(self, rows: Rows, given: Scenarios | None = None) -> None:
        """Start the next episode of some drives: the next of their streams, or ``given``."""
        fresh = self._next
        if given is not None:
            fresh = self._prepared(given)
        elif not self._ready[rows].all():
            self._draw(np.flatnonzero(~self._ready))
        source = rows if given is None else np.arange(len(rows))
        for first in range(0, len(rows), AT_ONCE):
            some = slice(first, first + AT_ONCE)
            at, of = rows[some], source[some]
            self._start(at, fresh.given[of])
            self._constant[at] = fresh.constant[of]
        self._ready[rows] = False
        self._episode[rows] += np.uint64(1)
        self._sums = self._copied_sums()

    def _draw(self, rows: Rows) -> None:
        """Prepare the next episode of some drives."""
        drawn = self.settings.sampler(self.motor, combine(self._seeds[rows], self._episode[rows]))
        if not isinstance(drawn, Scenarios):
            raise UserError(f"scenarios: gave {shown(drawn)} for {len(rows)} seeds; give Scenarios")
        drawn = checked_scenarios(drawn, len(rows), "scenarios")
        for first in range(0, len(rows), AT_ONCE):
            some = slice(first, first + AT_ONCE)
            fresh = self._prepared(drawn[some])
            self._next.given[rows[some]] = fresh.given
            self._next.constant[rows[some]] = fresh.constant
        self._ready[rows] = True

    def _prepared(self, scenarios: Scenarios) -> Prepared:
        sims = self._factory.build(scenarios)
        limit = self.settings.max_episode_steps
        if limit is not None:
            sims["k_end"] = np.minimum(sims["k_end"], min(limit * self.periods, lib.NEVER))
        return Prepared(words(sims)[:, _GIVEN], fixed(scenarios, self.motor))

    def _start(self, rows: Rows, given: Array) -> None:
        """Start some drives, and read their first signals."""
        sims = np.zeros(len(rows), dtype=SIM)
        words(sims)[:, _GIVEN] = given
        sim_start(sims)
        signals = np.zeros((len(rows), SIGNAL_N), dtype=np.float32)
        sim_signals(sims, signals)
        words(self._sims)[rows] = words(sims)
        self._signals[rows] = signals
        if self._columns:
            self._gains[rows] = gain_records(sims, self.settings.ranges, self._decision)
        if self._window is not None:
            self._window.clear(rows)

    def advance(self, actions: ArrayLike) -> None:
        """Advance every drive by one decision; those lost or at their end stay where they are.

        Parameters
        ----------
        actions : array, shape (n, n_actions), or flat for one drive or k_s alone
            k_s from -1 (0, all observer) to 1 (1, all injection), then the gains' values.

        Raises
        ------
        UserError
            As ``checked_actions``.
        """
        action = checked_actions(actions, len(self), self.n_actions)
        k_s = np.float32(0.5) * action[:, 0] + np.float32(0.5)
        if self._columns:
            self._gains["wanted"][:, : len(self._columns)] = action[:, self._columns]
        gains = self._gains if self._columns else None
        sim_run(self._sims, self.periods, k_s, self._signals, gains)
        self._sums = self._copied_sums()
        if self._window is not None:
            self._window.add(self._sums)

    def idle(self) -> Rows:
        """Drives that the last `advance` found at the end of their episode."""
        return np.flatnonzero(self._sums["n"] == 0.0)

    def outcome(self) -> Outcome:
        """Reward and end of the last decision; a drive that stayed or just began earns 0."""
        sums, bits = self._sums, self._sims["lost"]
        lost = just_lost = np.zeros(len(self), dtype=bool)
        ended = self._sims["k"] >= self._sims["k_end"]
        if np.count_nonzero(bits):
            lost = (bits & ~LOST_TWIN) != 0
            ended = (ended | (bits == LOST_TWIN)) & ~lost
            just_lost = lost & (sums["n"] > 0.0)
        weights = self.settings.weights
        if isinstance(weights, WindowWeights):
            assert self._window is not None
            parts = window_terms(self._window, sums, just_lost, weights, self.motor)
        else:
            parts = terms(sums, just_lost, weights, self.motor)
        alarm = np.asarray(self._sims["drive"]["x"]["lock"]["alarm"] != 0)
        return Outcome(total(parts), parts, lost, alarm, ended)

    def observation(self) -> Observation:
        """What a policy may see (n, SIGNAL_N), a copy."""
        return bounded(self._signals)

    def sums(self) -> Array:
        """Sums (n,) of the last decision, not a copy."""
        return self._sums

    def reference(self) -> Values:
        """Speed reference (n,) [rad/s], mechanical."""
        reference: Values = self._sims["now"]["omega_ref"] / self._sims["omega_scale"]
        return reference

    def privileged(self) -> Values:
        """What only a critic may see (n, N_PRIVILEGED), a copy."""
        return privileged(self._sims, self._constant, self.motor)

    def _copied_sums(self) -> Array:
        """Copy of ``sims["sums"]``."""
        return sums_matrix(self._sims).copy().view(SIM["sums"]).reshape(len(self))

    def state(self) -> BatchState:
        """Copy of all memory, for `restore`."""
        return BatchState(
            made=self._made,
            sims=self._sims.copy(),
            constant=self._constant.copy(),
            seeds=self._seeds.copy(),
            episode=self._episode.copy(),
            gains=self._gains.copy() if self._columns else None,
            window=None if self._window is None else self._window.ordered(),
        )

    def restore(self, state: BatchState) -> None:
        """Continue from a copy that `state` made; errors as in `checked_state`."""
        state = checked_state(state, self._made)
        self._sims[:] = state.sims
        self._constant[:] = state.constant
        self._seeds[:] = state.seeds
        self._episode[:] = state.episode
        if state.gains is not None:
            self._gains[:] = state.gains
        if self._window is not None and state.window is not None:
            self._window.restore(state.window)
        sim_signals(self._sims, self._signals)
        self._ready[:] = False
        self._sums = self._copied_sums()
