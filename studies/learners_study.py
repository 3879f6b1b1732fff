"""PPO on paired rollouts beside other learners: the same table, start, drives and decisions.

    python studies/learners_study.py ks
    python studies/learners_study.py gains --seeds 1 2 3

Every learner starts from Eq. 25 on the sliding-mode observer and gets the same number of decisions,
in updates of the same number of whole scenarios, with the same reward and the same size of
exploration where it has one; steps are as they stand here, not searched. The last table counts, a
mean of the last updates. All are judged on scenarios that none has seen.

    pairs   PPO as ``sensorless train`` has it
    ppo     PPO with reward to go: no pairs, a scenario of its own in each environment
    es      evolution strategy: antithetic noise on the nodes, held for a scenario that both share;
            the gradient is that of OpenAI-ES (arXiv 1703.03864) with ranks of the differences
    cma     CMA-ES over the nodes; all candidates of a generation run the same scenarios
    rule    CMA-ES over the seven numbers of the logistic rule, as ``sensorless tune``; k_s alone
"""

import argparse
import json
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3.common.buffers import RolloutBuffer
from stable_baselines3.common.callbacks import BaseCallback
from torch import Tensor

from sensorless.agents.pairs import opposite, paired_seeds, restart
from sensorless.agents.table.kernel import NodeKernel
from sensorless.agents.table.module import TableModule
from sensorless.agents.table.policy import TableActorCritic
from sensorless.agents.train.config import TrainConfig
from sensorless.agents.train.env import stream, training_env
from sensorless.agents.train.sb3_adapter import SB3VecEnv
from sensorless.agents.train.train import new_model
from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import in_one_line
from sensorless.evaluation.evaluate import score
from sensorless.evaluation.over_seeds import change_over_seeds, survived
from sensorless.files import check_writable, write_atomic
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy, rule_named, table_named
from sensorless.policy import TablePolicy
from sensorless.table.ks_table import KsTable
from sensorless.tuning.evolution import evolution
from sensorless.tuning.tune import tune
from sensorless.versions import versions

MOTOR, DESIGN = Motor.load("paper"), DriveDesign(estimator="smo")
FACTORY = SimFactory(MOTOR, DESIGN)
NAMES = ("torque_dev_rms", "torque_ripple_rms", "overshoot_excess_pct", "injection_share")
LAST = 5
"""Updates whose mean table counts"""
JUDGE = "stress-1", 11


@dataclass(frozen=True)
class Case:
    """What the agent sets."""

    train: Mapping[str, Any]
    steps: int
    """Decisions of a learner"""


START = "eq25"
SHARED: dict[str, Any] = {"start": START, "margin": 0.05, "smoothness": 1.0, "outlier": 10.0,
          "hard": 0.1, "n_envs": 128}  # fmt: skip
CASES = {
    "ks": Case({}, 1_000_000),
    "gains": Case(
        {
            "gains": "observer,injection,l_q,amplitude:0.5:1.5",
            "axes": "speed:0:0.5333333:9,torque_current:-1:1:3,disagreement:-1:1:3",
            "ripple_cost": 0.06,
        },
        2_000_000,
    ),
}
STEPS = {"pairs": 0.02, "ppo": 0.02, "es": 0.02, "cma": 0.1, "rule": 0.2}
"""Step of each learner: of Adam on the nodes, of CMA-ES its first sigma."""


class Updates(BaseCallback):
    """Scenarios, rates and the warm-up of the critic, as in a training of the command."""

    def __init__(self, config: TrainConfig, *, pairs: bool) -> None:
        super().__init__()
        self._config, self._pairs, self._done = config, pairs, 0
        self.tables: list[Tensor] = []

    def _on_rollout_start(self) -> None:
        policy = self.model.policy
        assert isinstance(policy, TableActorCritic)
        left = falling(self._config, self._done)
        for group, whole in zip(policy.optimizer.param_groups, policy.steps(), strict=True):
            group["lr"] = left * whole
        first, env = stream(self._config.seed, self.model.num_timesteps), self.model.env
        restart(self.model, first)
        if not self._pairs:
            assert isinstance(env, SB3VecEnv)
            env.seed_each([first + i for i in range(env.num_envs)])
            self.model._last_obs = env.reset()
        policy.learn_actor = self._done >= self._config.warm_up
        self._done += 1
        self.tables.append(policy.vector())

    def _on_step(self) -> bool:
        return True


def updates(config: TrainConfig) -> int:
    """Updates that the decisions suffice for."""
    return config.steps // (config.n_envs * config.n_steps)


def falling(config: TrainConfig, done: int) -> float:
    """Share of the step that is left."""
    return 1.0 - (1.0 - config.lr_end) * done / updates(config)


def by_ppo(config: TrainConfig, table: KsTable, *, pairs: bool) -> KsTable:
    """PPO, on paired rollouts or with reward to go."""
    model = new_model(config, table, training_env(config, DESIGN, [MOTOR]))
    if not pairs:
        old = model.rollout_buffer
        model.rollout_buffer = RolloutBuffer(
            old.buffer_size, old.observation_space, old.action_space, device="cpu",
            gae_lambda=config.gae_lambda, gamma=config.gamma, n_envs=config.n_envs,
        )  # fmt: skip
    told = Updates(config, pairs=pairs)
    model.learn(updates(config) * config.n_envs * config.n_steps, callback=told)
    policy = model.policy
    assert isinstance(policy, TableActorCritic)
    last = torch.stack([*told.tables, policy.vector()][-LAST:]).mean(dim=0)
    return policy.schedule(last).table


def earned(env: SB3VecEnv, actor: TableModule, nodes: Tensor, seeds: list[int]) -> Tensor:
    """Return (n,) of the first episode of each environment under its own nodes (n, outputs, m)."""
    env.seed_each(seeds)
    obs: Any = env.reset()
    lives = np.ones(env.num_envs, dtype=bool)
    total = np.zeros(env.num_envs)
    nodes = torch.cat((nodes[:, :1].clamp(0.0, 1.0), nodes[:, 1:]), dim=1)
    while lives.any():
        at, frac, _ = actor.corners(torch.as_tensor(obs))
        each = [actor.mixed(grid.gather(1, at), frac) for grid in nodes.unbind(1)]
        action = torch.stack([2.0 * each[0] - 1.0, *each[1:]], dim=1)
        obs, reward, done, _ = env.step(action.clamp(-1.0, 1.0).numpy())
        total += np.where(lives, reward, 0.0)
        lives &= ~done
    return torch.as_tensor(total, dtype=torch.float32)


def actor_of(config: TrainConfig, table: KsTable) -> tuple[TableModule, Tensor]:
    """Table to act with, and the size of the noise (outputs, 1): k_s is half an action."""
    actor = TableModule(table, config.margin)
    size = torch.full((actor.outputs, 1), 2.0 * config.noise)
    size[0] = config.noise
    return actor, size


def within(actor: TableModule, vector: Tensor) -> Tensor:
    """Nodes (outputs, m) brought into their range, as after a step of PPO."""
    nodes = vector.reshape(actor.outputs, -1)
    with torch.no_grad():
        actor.values.copy_(nodes[0])
        if actor.gains is not None:
            actor.gains.copy_(nodes[1:])
        actor.project()
    return actor.vector().reshape(nodes.shape)


def by_es(config: TrainConfig, table: KsTable) -> KsTable:
    """Evolution strategy with antithetic pairs and Adam."""
    torch.manual_seed(config.seed)
    env = training_env(config, DESIGN, [MOTOR])
    actor, size = actor_of(config, table)
    kernel, pairs = NodeKernel(actor.shape, config.smoothness), config.n_envs // 2
    mean, tables = actor.vector().reshape(actor.outputs, -1).requires_grad_(), []
    adam = torch.optim.Adam([mean], lr=config.lr_nodes)
    for done in range(updates(config)):
        z = kernel.sample(pairs * actor.outputs).reshape(pairs, actor.outputs, -1)
        nodes = mean.detach() + size * opposite(z)
        got = earned(env, actor, nodes, paired_seeds(stream(config.seed, done), config.n_envs))
        apart = got[0::2] - got[1::2]
        weight = torch.sign(apart) * (apart.abs().argsort().argsort() + 1.0) / pairs
        mean.grad = -(weight[:, None, None] * z).mean(dim=0)
        adam.param_groups[0]["lr"] = falling(config, done) * config.lr_nodes
        adam.step()
        with torch.no_grad():
            mean.copy_(within(actor, mean))
        tables.append(actor.vector())
    return actor.table(torch.stack(tables[-LAST:]).mean(dim=0))


def by_cma(config: TrainConfig, table: KsTable) -> KsTable:
    """CMA-ES over all nodes; each candidate runs its share of the scenarios of an update."""
    env = training_env(config, DESIGN, [MOTOR])
    actor, _ = actor_of(config, table)
    start, n = actor.vector(), actor.values.numel()
    low, high = torch.full_like(start, -1.0), torch.full_like(start, 1.0)
    low[:n], high[:n] = -config.margin, 1.0 + config.margin
    es = evolution(start.tolist(), config.lr_nodes, config.seed, low.tolist(), high.tolist())
    each = config.n_envs // es.popsize
    rows = torch.arange(config.n_envs) // each % es.popsize
    for done in range(updates(config)):
        points = es.ask()
        nodes = torch.stack([within(actor, torch.tensor(x).float()) for x in points])[rows]
        first = stream(config.seed, done)
        got = earned(env, actor, nodes, [first + i % each for i in range(config.n_envs)])
        cost = -got[: es.popsize * each].reshape(es.popsize, each).mean(dim=1)
        es.tell(points, cost.tolist())
    return actor.table(within(actor, torch.tensor(es.result.xfavorite).float()).reshape(-1))


def learned(who: str, case: Case, seed: int, steps: int) -> TablePolicy:
    """Schedule of one learner and one seed."""
    words = {**SHARED, **case.train, "seed": seed, "steps": steps, "lr_nodes": STEPS[who]}
    config = TrainConfig(**words)
    table = config.start_table(table_named(config.start, MOTOR), MOTOR, DESIGN.k_s_slew)
    if who == "rule":
        budget = 1e-3 * config.decision_ms * steps
        found = tune("logistic", MOTOR, DESIGN, budget, seed)
        policy = rule_named("logistic").build(who, found.parameters, MOTOR)
        assert isinstance(policy, TablePolicy)
        return policy
    make = {"es": by_es, "cma": by_cma}.get(who)
    table = by_ppo(config, table, pairs=who == "pairs") if make is None else make(config, table)
    return TablePolicy(who, table)


def study(
    case: Case, who: Sequence[str], words: argparse.Namespace, out: dict[str, Any]
) -> Iterator[dict[str, Any]]:
    """Train and judge all learners of a case; what is found so far, after each."""
    rows = SuiteRows(JUDGE[0], MOTOR, JUDGE[1], words.size)
    start = score(make_policy(START, MOTOR), rows, FACTORY)
    out[START] = survived(start, NAMES)
    for name in who:
        began = time.process_time()
        policies = [learned(name, case, seed, words.steps or case.steps) for seed in words.seeds]
        taken = (time.process_time() - began) / len(policies)
        scores = [score(p, rows, FACTORY) for p in policies]
        against = {m: change_over_seeds(scores, start, m) for m in NAMES}
        facts = {"step": STEPS[name], "cpu_s_a_seed": round(taken, 1)}
        each = [survived(s, NAMES) for s in scores]
        out[name] = {**facts, "seeds": each, "against start": against}
        print(name, json.dumps(out[name], indent=1), flush=True)
        yield out


def main() -> None:
    """Run one case."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("case", choices=list(CASES))
    parser.add_argument("--seeds", type=a_seed, nargs="+", default=[1, 2, 3, 4, 5])
    parser.add_argument("--learners", nargs="+", choices=list(STEPS))
    parser.add_argument("--steps", type=int, default=0, help="decisions of a learner; 0: its own")
    parser.add_argument("--size", type=a_count, default=2000, help="scenarios to judge on")
    parser.add_argument("--out", type=Path, default=Path("results/studies/learners.json"))
    words = parser.parse_args()
    check_writable(words.out)
    case = CASES[words.case]
    who = words.learners or [w for w in STEPS if w != "rule" or words.case == "ks"]
    known = json.loads(words.out.read_text(encoding="utf-8")) if words.out.is_file() else {}
    asked = {"settings": {**SHARED, **case.train}, "steps": words.steps or case.steps,
             "judged on": list(JUDGE), "size": words.size, "train_seeds": words.seeds}  # fmt: skip
    old = known.get(words.case, {})
    before = old["learners"] if {key: old.get(key) for key in asked} == asked else {}
    for found in study(case, who, words, before):
        command = " ".join(("python", *sys.argv))
        known[words.case] = {**asked, "command": command, "learners": found, "versions": versions()}
        write_atomic(words.out, json.dumps(known) + "\n")


if __name__ == "__main__":
    in_one_line(main)
