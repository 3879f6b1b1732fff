"""Adapts the native vector environment to stable-baselines3. Imports torch: import it late."""

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv
from stable_baselines3.common.vec_env.base_vec_env import VecEnvIndices, VecEnvStepReturn

from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.privileged import BOUND, N_PRIVILEGED
from sensorless.envs.several import SeveralMachines
from sensorless.envs.signals import HIGH, LOW
from sensorless.errors import UserError, shown

Floats = NDArray[np.float32]


class SB3VecEnv(VecEnv):
    """A `BlendVectorEnv` in ``SAME_STEP`` mode as a VecEnv, without processes or copies.

    ``last_info`` holds the vector environment's info of the last step: every term of the reward as
    one array, for a callback to log.

    Parameters
    ----------
    env : BlendVectorEnv or SeveralMachines
    privileged : bool
        Append the N_PRIVILEGED true quantities for a critic to the N_SIGNALS columns of the policy,
        and with several machines one more column per machine, which is 1 in its own rows. The actor
        must not read beyond its own columns.

    Raises
    ------
    UserError
        It is another environment, or has another autoreset mode.
    """

    def __init__(self, env: BlendVectorEnv | SeveralMachines, *, privileged: bool = False) -> None:
        if not isinstance(env, BlendVectorEnv | SeveralMachines):
            raise UserError(
                f"env: {shown(env)}; give BlendVectorEnv, as gymnasium.make_vec gives it; one "
                "drive of gymnasium.make goes into stable-baselines3 as it is"
            )
        if env.metadata["autoreset_mode"] is not AutoresetMode.SAME_STEP:
            raise UserError(f"autoreset_mode: {env.metadata['autoreset_mode'].value!r}; "
                            "stable-baselines3 needs 'SameStep'")  # fmt: skip
        self.env = env  # before the base class, which asks for env.render_mode
        self.privileged = privileged
        self.last_info: dict[str, Any] = {}
        self._which = _which(env) if privileged else np.zeros((env.num_envs, 0), dtype=np.float32)
        n_extra = N_PRIVILEGED + self._which.shape[1] if privileged else 0
        extra = np.full(n_extra, BOUND, dtype=np.float32)
        low, high = np.concatenate([LOW, -extra]), np.concatenate([HIGH, extra])
        space = gymnasium.spaces.Box(low, high, dtype=np.float32)
        super().__init__(env.num_envs, space, env.single_action_space)

    def _columns(self, observation: Floats, info: dict[str, Any]) -> Floats:
        """Columns of the policy, then those of the critic."""
        if not self.privileged:
            return observation
        return np.concatenate([observation, info["privileged"], self._which], axis=-1)

    def seed_each(self, seeds: Sequence[int]) -> None:
        """Set the seed of every drive for the next reset."""
        self._seeds = list(seeds)

    def reset(self) -> Floats:
        """Begin an episode in every drive, with the seeds and options that were set."""
        seeds = None if self._seeds[0] is None else self._seeds
        observation, info = self.env.reset(seed=seeds, options=self._options[0] or None)
        self._reset_seeds()
        self._reset_options()
        self.reset_infos = [{} for _ in range(self.num_envs)]
        return self._columns(observation, info)

    def step_async(self, actions: Floats) -> None:
        """Keep the actions for `step_wait`."""
        self._actions = actions

    def step_wait(self) -> VecEnvStepReturn:
        """Advance every drive by one decision; a drive at its end begins a new episode at once."""
        observation, reward, terminated, truncated, info = self.env.step(self._actions)
        self.last_info = info
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(terminated | truncated):
            final = info["final_info"]
            last = [info["final_obs"][i]]
            if self.privileged:
                last += [final["privileged"][i], self._which[i]]
            infos[i]["terminal_observation"] = np.concatenate(last)
            infos[i]["TimeLimit.truncated"] = bool(truncated[i])
            infos[i]["lost"] = bool(final["lost"][i])
        return self._columns(observation, info), reward, terminated | truncated, infos

    def close(self) -> None:
        """Close the environment."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: VecEnvIndices = None) -> list[Any]:
        """Return the attribute of the one environment, repeated for every drive asked for."""
        value = getattr(self.env, attr_name)
        return [value for _ in self._get_indices(indices)]

    def set_attr(self, attr_name: str, value: Any, indices: VecEnvIndices = None) -> None:
        """Set an attribute of the one environment, for all drives."""
        if indices is not None:
            raise NotImplementedError("the drives share their attributes: leave indices out")
        setattr(self.env, attr_name, value)

    def env_method(
        self, method_name: str, *args: Any, indices: VecEnvIndices = None, **kwargs: Any
    ) -> list[Any]:
        """Refuse: there are no single environments to call."""
        raise NotImplementedError(f"call {method_name} on the vector environment itself")

    def env_is_wrapped(
        self,
        wrapper_class: type[gymnasium.Wrapper[Any, Any, Any, Any]],
        indices: VecEnvIndices = None,
    ) -> list[bool]:
        """Return False for every drive asked for."""
        return [False for _ in self._get_indices(indices)]


def _which(env: BlendVectorEnv | SeveralMachines) -> Floats:
    """One column per machine, 1 in its rows (n, m); no column for a single machine."""
    if isinstance(env, BlendVectorEnv):
        return np.zeros((env.num_envs, 0), dtype=np.float32)
    sizes = [part.num_envs for part in env.envs]
    return np.repeat(np.eye(len(sizes), dtype=np.float32), sizes, axis=0)
