"""Many drives as one Gymnasium vector environment, advanced by one call of the core."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.error import ResetNeeded
from gymnasium.spaces import Box
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike

from sensorless.envs.batch_state import BatchState
from sensorless.envs.blend_batch import BlendBatch, Flags, Outcome
from sensorless.envs.blend_settings import (
    BlendSettings,
    checked_count,
    checked_render_mode,
    checked_scenario,
    checked_seeds,
)
from sensorless.envs.reward import Term
from sensorless.envs.signals import HIGH, LOW, Observation
from sensorless.errors import UserError

Step = tuple[Observation, Term, Flags, Flags, dict[str, Any]]


def spaces(n_actions: int) -> "tuple[Box[np.float32], Box[np.float32]]":
    """Observation and action space of one drive."""
    return (
        Box(LOW, HIGH, dtype=np.float32),
        Box(-1.0, 1.0, (n_actions,), dtype=np.float32),
    )


class BlendVectorEnv(VectorEnv[Observation, ArrayLike, Any]):
    """``sensorless/Blend-v0`` for n drives; `BlendEnv` describes action, observation and reward.

    With seed s, drive i equals the single environment with seed s + i, to the bit, as Gymnasium has
    it: n drives of seeds s and s + 1 share n - 1 streams. Seeds n apart share none.

    The ``info`` of a step has the terms of the reward (``reward.TERMS``), ``lost``, ``alarm`` and
    ``privileged`` (n, N_PRIVILEGED), true quantities for a critic that no policy may see. Each key
    has a mask ``_key`` of the drives it applies to, as in Gymnasium's own vector environments; but
    it is there in every step, with a mask of False where it applies to none.

    A drive whose episode ended begins its next scenario by itself, in one of two modes:

    - ``NEXT_STEP`` (default): in the following step, whose action must be valid but has no effect,
      and whose reward is 0.
    - ``SAME_STEP``: at once. Observation and ``privileged`` are the first of the new episode; the
      last of the old one are in ``info["final_obs"]`` and ``info["final_info"]``. Terms,
      ``lost`` and ``alarm`` belong to the reward returned with them, so their masks are True.

    Parameters
    ----------
    num_envs : int
    autoreset_mode : AutoresetMode or str
        ``"NextStep"`` or ``"SameStep"``.
    render_mode : None
        There is nothing to render; use ``sensorless simulate`` for pictures.
    **settings
        Fields of `BlendSettings`: motor, design, scenarios, weights, decision_period [s] and
        max_episode_steps.
    """

    settings_type: type[BlendSettings] = BlendSettings

    def __init__(
        self,
        num_envs: int = 1,
        *,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: None = None,
        **settings: Any,
    ) -> None:
        mode = _checked_mode(autoreset_mode)
        self.num_envs = checked_count(num_envs)
        self.batch = BlendBatch(self.num_envs, self.settings_type.by_name(settings))
        self.render_mode = checked_render_mode(render_mode, ())
        self.metadata = {"render_modes": [], "autoreset_mode": mode}
        self.single_observation_space, self.single_action_space = spaces(self.batch.n_actions)
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        self._same_step = mode is AutoresetMode.SAME_STEP
        self._all = np.arange(self.num_envs)
        self._begun = False

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode in every drive.

        Parameters
        ----------
        seed : int, list or None
            s seeds the drives with s, s + 1, ...; a list has one seed per drive. With None the
            streams continue.
        options : dict, optional
            ``{"scenario": Scenarios}``, one row per drive, replaces the streams' next scenarios.
            They do not know which machine they were drawn for: draw them for this one.
        """
        seeds = checked_seeds(seed, self.num_envs)
        scenario = checked_scenario(options, self.num_envs)
        super().reset(seed=seeds[0])
        rows = [i for i, s in enumerate(seeds) if s is not None or not self._begun]
        if rows:
            drawn = self.np_random.integers(2**63, size=self.num_envs)
            self.batch.seed(np.array(rows), [_first(seeds[i], drawn[i]) for i in rows])
        self.batch.begin(self._all, scenario)
        self._begun = True
        return self.batch.observation(), _masked({"privileged": self.batch.privileged()})

    def step(self, actions: ArrayLike) -> Step:
        """Advance every drive by one decision.

        Parameters
        ----------
        actions : array, shape (n, 1), or more columns with gains
            -1 to 1 for k_s from 0 to 1.
        """
        if not self._begun:
            raise ResetNeeded("call reset() before step()")
        self.batch.advance(actions)
        return self._step_same() if self._same_step else self._step_next()

    def _step_next(self) -> Step:
        idle = self.batch.idle()
        if len(idle):
            self.batch.begin(idle)
        outcome = self.batch.outcome()
        info = _masked({**self._scores(outcome), "privileged": self.batch.privileged()})
        if len(idle):
            moved = np.ones(self.num_envs, dtype=bool)
            moved[idle] = False
            info |= {f"_{name}": moved for name in (*outcome.terms, "lost", "alarm")}
        return self.batch.observation(), outcome.reward, outcome.lost, outcome.ended, info

    def _step_same(self) -> Step:
        outcome = self.batch.outcome()
        observation, privileged = self.batch.observation(), self.batch.privileged()
        info = self._scores(outcome)
        over = outcome.lost | outcome.ended
        final: dict[str, Any] = {}
        if over.any():
            last = np.full(self.num_envs, None, dtype=object)
            for i in np.flatnonzero(over):
                last[i] = observation[i]
            last_info = _masked({**self._scores(outcome), "privileged": privileged}, over)
            final = {"final_obs": last, "_final_obs": over, "final_info": last_info,
                     "_final_info": over}  # fmt: skip
            self.batch.begin(np.flatnonzero(over))
            observation, privileged = self.batch.observation(), self.batch.privileged()
        info = _masked({**info, "privileged": privileged}) | final
        return observation, outcome.reward, outcome.lost, outcome.ended, info

    @staticmethod
    def _scores(outcome: Outcome) -> dict[str, Any]:
        return {**outcome.terms, "lost": outcome.lost.copy(), "alarm": outcome.alarm}

    def state(self) -> BatchState:
        """Copy of all memory of the drives."""
        return self.batch.state()

    def restore(self, state: BatchState) -> None:
        """Continue from a copy that `state` made with the same settings; errors otherwise.

        Scenarios that a function draws are compared by its name alone.
        """
        self.batch.restore(state)
        self._begun = True


def _checked_mode(mode: AutoresetMode | str) -> AutoresetMode:
    name = mode.value if isinstance(mode, AutoresetMode) else mode
    if name not in ("NextStep", "SameStep"):
        raise UserError(f"autoreset_mode: {name!r}; choose 'NextStep' or 'SameStep'")
    return AutoresetMode(name)


def _masked(info: dict[str, Any], mask: Flags | None = None) -> dict[str, Any]:
    """Add Gymnasium's mask to each key of an info: the drives it applies to, by default all."""
    if mask is None:
        mask = np.ones(len(info["privileged"]), dtype=bool)
    return info | {f"_{name}": mask for name in info}


def _first(seed: int | None, drawn: np.int64) -> int:
    """Return the given seed, or the drawn one without it."""
    return int(drawn) if seed is None else seed
