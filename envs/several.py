"""Vector environments of different machines joined into one."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import ArrayLike

from sensorless.envs.blend_settings import checked_actions, checked_seeds
from sensorless.envs.blend_vector_env import BlendVectorEnv, Step
from sensorless.envs.signals import Observation
from sensorless.errors import UserError, shown

FINAL = ("final_obs", "_final_obs", "final_info", "_final_info")


class SeveralMachines(VectorEnv[Observation, ArrayLike, Any]):
    """Drives of the first environment, then those of the second, and so on.

    Each row is what its own environment returns, to the bit. The core is fastest with a multiple of
    sixteen drives per machine.

    Parameters
    ----------
    envs : sequence of BlendVectorEnv
        One or more, all with ``autoreset_mode="SameStep"``, one decision period and the same gains.

    Raises
    ------
    UserError
        There is no environment, or one with another autoreset mode, decision period or gains.
    """

    envs: tuple[BlendVectorEnv, ...] = ()  # what was refused is closed, too, when it is deleted

    def __init__(self, envs: Sequence[BlendVectorEnv]) -> None:
        for env in envs:
            if not isinstance(env, BlendVectorEnv):
                raise UserError(f"envs: {type(env).__name__}; give environments BlendVectorEnv")
        modes = {env.metadata["autoreset_mode"] for env in envs}
        if modes != {AutoresetMode.SAME_STEP}:
            found = ", ".join(sorted(mode.value for mode in modes)) or "no environment"
            raise UserError(f"envs: {found}; give one or more with autoreset_mode 'SameStep'")
        first = envs[0].batch.settings
        for own in (env.batch.settings for env in envs):
            for name, one, other in (
                ("decision_period", first.decision_period, own.decision_period),
                ("gains", list(first.ranges.items()), list(own.ranges.items())),
            ):
                if one != other:
                    raise UserError(f"envs: {name}: {shown(one)} and {shown(other)}; give one")
        self.envs = tuple(envs)
        self.num_envs = sum(env.num_envs for env in envs)
        self.render_mode = None
        self.metadata = envs[0].metadata
        self.single_observation_space = envs[0].single_observation_space
        self.single_action_space = envs[0].single_action_space
        self.observation_space = batch_space(self.single_observation_space, self.num_envs)
        self.action_space = batch_space(self.single_action_space, self.num_envs)
        ends = np.cumsum([env.num_envs for env in envs]).tolist()
        self._rows = [slice(end - e.num_envs, end) for e, end in zip(envs, ends, strict=True)]

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode in every drive; seeds as in ``BlendVectorEnv``, and no options.

        Raises
        ------
        UserError
            There are options, since scenarios belong to one machine, or as ``checked_seeds``.
        """
        if options:
            raise UserError(f"options: {', '.join(options)}; several machines take no options")
        seeds = checked_seeds(seed, self.num_envs)
        parts = [
            env.reset(seed=seeds[rows]) for env, rows in zip(self.envs, self._rows, strict=True)
        ]
        return np.concatenate([obs for obs, _ in parts]), _joined([info for _, info in parts])

    def step(self, actions: ArrayLike) -> Step:
        """Advance every drive by one decision; as in ``BlendVectorEnv``."""
        action = checked_actions(actions, self.num_envs, self.envs[0].batch.n_actions)
        parts = [env.step(action[rows]) for env, rows in zip(self.envs, self._rows, strict=True)]
        obs, reward, terminated, truncated, infos = zip(*parts, strict=True)
        return (
            np.concatenate(obs),
            np.concatenate(reward),
            np.concatenate(terminated),
            np.concatenate(truncated),
            _joined(infos),
        )

    def close_extras(self, **kwargs: Any) -> None:
        """Close the environments."""
        for env in self.envs:
            env.close()


def _joined(infos: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Join the infos of all environments, with final observations if any episode ended."""
    now = [{name: x for name, x in info.items() if name not in FINAL} for info in infos]
    joined: dict[str, Any] = {name: np.concatenate([info[name] for info in now]) for name in now[0]}
    if any("final_obs" in info for info in infos):
        last = [info if "final_obs" in info else _nothing_ended(info) for info in infos]
        for name in ("final_obs", "_final_obs", "_final_info"):
            joined[name] = np.concatenate([info[name] for info in last])
        joined["final_info"] = _joined([info["final_info"] for info in last])
    return joined


def _nothing_ended(info: dict[str, Any]) -> dict[str, Any]:
    """Final observations of an environment where no episode ended: every mask is false."""
    none = np.zeros(len(info["lost"]), dtype=bool)
    final = {name: none if name.startswith("_") else x for name, x in info.items()}
    return {"final_obs": np.full(len(none), None, dtype=object), "_final_obs": none,
            "final_info": final, "_final_info": none}  # fmt: skip
