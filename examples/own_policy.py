"""A stable-baselines3 model as a policy that every command takes, by MODULE:NAME.

    python examples/ppo.py 4000000   # first: it writes ppo.zip into this folder
    sensorless evaluate --policy eq25 --policy examples.own_policy:Model --suite stress-1 --seed 7
    sensorless certify examples.own_policy:Model --size 20000

NAME is a class or a function of the motor. What it gives must have ``act``; ``name``, ``settings``
(of the drive, for example ``{"estimator": "smo"}``) and ``reset(n)`` are optional. A policy that
sets gains besides has ``ranges`` and ``act_gains`` both: one without the other is refused.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from stable_baselines3 import PPO

from sensorless.core.gains import DEFAULT, GAIN_N, GAIN_NAMES
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

FILE = Path("ppo.zip")
"""What examples/ppo.py writes."""


class Model:
    """Weights from the network that ``FILE`` holds."""

    name = "my-ppo"

    def __init__(self, motor: Motor) -> None:
        if not FILE.is_file():
            raise UserError(f"{FILE}: no such file here; first run: python examples/ppo.py")
        self._model = PPO.load(FILE, device="cpu")
        actions = int(np.prod(self._model.action_space.shape or ()))
        if actions not in (1, 1 + len(DEFAULT)):
            raise UserError(f"{FILE}: {actions} actions; train on k_s alone, or with all gains")
        self.ranges = {} if actions == 1 else DEFAULT  # with all gains of Blend-v1

    def act(self, obs: NDArray[np.float32]) -> NDArray[np.float32]:
        """Weights (n,) of n drives at their signals (n, 12), every millisecond."""
        action, _ = self._model.predict(obs, deterministic=True)
        return np.asarray(0.5 * (action[:, 0] + 1.0), dtype=np.float32)

    def act_gains(self, obs: NDArray[np.float32]) -> NDArray[np.float32]:
        """Values of the gains (n, GAIN_N), -1 to 1, of a model that sets them."""
        action, _ = self._model.predict(obs, deterministic=True)
        values = np.zeros((len(obs), GAIN_N), dtype=np.float32)
        values[:, [GAIN_NAMES.index(name) for name in DEFAULT]] = action[:, 1:]
        return values
