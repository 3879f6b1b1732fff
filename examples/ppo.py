"""Plain PPO of stable-baselines3 against Eq. 25: python examples/ppo.py [STEPS].

4 million steps take two to three minutes. They end at a return of -5.7 where Eq. 25 has -4.1, as
the last lines print: plain PPO does not reach the rule with these settings. `sensorless train`
does, on paired rollouts.
"""

import argparse

import torch
from stable_baselines3 import PPO
from stable_baselines3.common.vec_env import VecMonitor

from sensorless.agents.train.sb3_adapter import SB3VecEnv
from sensorless.cli.study_numbers import a_count
from sensorless.envs.blend_v1 import GainVectorEnv
from sensorless.envs.returns import acts, returns
from sensorless.policies.registry import make_policy

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument(
    "steps", type=a_count, nargs="?", default=4_000_000, help="decisions to train for"
)
steps = parser.parse_args().steps

torch.set_num_threads(1)
env = GainVectorEnv(256, autoreset_mode="SameStep", gains=())  # k_s alone
model = PPO(
    "MlpPolicy",
    VecMonitor(SB3VecEnv(env)),  # logs the return of an episode
    n_steps=100,  # half a second, the time after which an angle shows in the speed
    batch_size=3200,
    n_epochs=4,
    learning_rate=lambda left: 1e-3 * left,
    gamma=0.99,
    policy_kwargs={"log_std_init": -1.0},
    seed=1,
    device="cpu",
    verbose=1,
)
model.learn(steps, log_interval=10)
model.save("ppo.zip")  # for examples/own_policy.py

judge = GainVectorEnv(1024, gains=())
eq25 = make_policy("eq25", judge.batch.motor)
print("Eq. 25", returns(judge, acts(eq25, judge), 10**6).mean())
print("PPO   ", returns(judge, lambda obs: model.predict(obs, deterministic=True)[0], 10**6).mean())
