"""A stable-baselines3 model as a policy that every command takes, by MODULE:NAME.

    python examples/ppo.py 4000000
    sensorless evaluate --policy eq25 --policy examples.own_policy:Model --suite stress-1 --seed 7
    sensorless certify examples.own_policy:Model --size 20000

NAME is a class or a function of the motor. What it gives must have ``act``; ``name``, ``settings``
(of the drive, for example ``{"estimator": "smo"}``) and ``reset(n)`` are optional.
"""

import numpy as np
from numpy.typing import NDArray
from stable_baselines3 import PPO

from sensorless.machine.motor import Motor

FILE = "ppo.zip"
"""What examples/ppo.py writes."""


class Model:
    """Weights from the network that ``FILE`` holds."""

    name = "my-ppo"

    def __init__(self, motor: Motor) -> None:
        self._model = PPO.load(FILE, device="cpu")

    def act(self, obs: NDArray[np.float32]) -> NDArray[np.float32]:
        """Weights (n,) of n drives at their signals (n, 12), every millisecond."""
        action, _ = self._model.predict(obs, deterministic=True)
        return np.asarray(0.5 * (action[:, 0] + 1.0), dtype=np.float32)
