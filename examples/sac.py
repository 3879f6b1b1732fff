"""Plain SAC of stable-baselines3 against Eq. 25: python examples/sac.py [STEPS]."""

import argparse

import torch
from stable_baselines3 import SAC
from stable_baselines3.common.vec_env import VecMonitor

from sensorless.agents.train.sb3_adapter import SB3VecEnv
from sensorless.cli.study_numbers import a_count
from sensorless.envs.blend_v1 import GainVectorEnv
from sensorless.envs.returns import acts, returns
from sensorless.policies.registry import make_policy

parser = argparse.ArgumentParser(description=__doc__)
parser.add_argument(
    "steps", type=a_count, nargs="?", default=600_000, help="decisions to train for"
)
steps = parser.parse_args().steps

torch.set_num_threads(1)
env = GainVectorEnv(64, autoreset_mode="SameStep", gains=())  # k_s alone
model = SAC(
    "MlpPolicy",
    VecMonitor(SB3VecEnv(env)),  # logs the return of an episode
    learning_starts=25_600,  # one scenario of every drive
    train_freq=1,
    gradient_steps=2,
    batch_size=1024,
    learning_rate=1e-3,
    gamma=0.99,
    ent_coef=0.001,  # costs of a decision are that small
    policy_kwargs={"net_arch": [64, 64]},
    seed=1,
    device="cpu",
    verbose=1,
)
model.learn(steps)

judge = GainVectorEnv(1024, gains=())
eq25 = make_policy("eq25", judge.batch.motor)
print("Eq. 25", returns(judge, acts(eq25, judge), 10**6).mean())
print("SAC   ", returns(judge, lambda obs: model.predict(obs, deterministic=True)[0], 10**6).mean())
