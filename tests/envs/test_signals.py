import math
import re

import numpy as np

from sensorless.core.api import SIGNAL_NAMES, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs import reward
from sensorless.envs.blend_env import BlendEnv
from sensorless.envs.counter_random import combine
from sensorless.envs.reward import TERMS, RewardWeights
from sensorless.envs.scenarios.scenario import LOST_ANGLE_DEG, LOST_TIME, SimFactory
from sensorless.envs.scenarios.stress import DURATION, stress_1_scenarios
from sensorless.envs.signals import HIGH, LOW, N_SIGNALS, SIGNALS, bounded
from sensorless.machine.motor import Motor


def test_table_agrees_with_the_core() -> None:
    assert tuple(s.name for s in SIGNALS) == SIGNAL_NAMES
    assert N_SIGNALS == len(SIGNAL_NAMES)
    assert np.all(np.isfinite(LOW)) and np.all(np.isfinite(HIGH)) and np.all(LOW < HIGH)


def test_datasheet_lists_every_signal() -> None:
    rows = [line.split("|")[1:-1] for line in str(BlendEnv.__doc__).splitlines() if "|" in line]
    cells = [[cell.strip() for cell in row] for row in rows[2:]]
    assert [(int(c[0]), c[1], c[2], float(c[4]), float(c[5])) for c in cells] == [
        (i, s.name, s.unit, s.low, s.high) for i, s in enumerate(SIGNALS)
    ]
    assert all(c[3].startswith(s.scale) for c, s in zip(cells, SIGNALS, strict=True))


def test_datasheet_states_the_figures_of_the_code() -> None:
    """Reward bounds, penalty, limits and sizes that the text of the environment names."""
    text = " ".join(str(BlendEnv.__doc__).split())
    weights = RewardWeights()
    (bound,) = re.findall(r"together at most ([\d.]+) per 1 ms", text)
    assert weights.worst_running <= float(bound) < weights.worst_running + 0.01
    assert f"lost_penalty (-{weights.lost:g}, once)" in text
    assert all(name in text for name in TERMS)
    assert f"``Box(({N_SIGNALS},), float32)``" in text
    lost = f"beyond {LOST_ANGLE_DEG:g} degrees for more than {1e3 * LOST_TIME:g} ms"
    assert lost in text and f"({DURATION:g} s by default)" in text


def test_reward_states_the_figures_of_the_code() -> None:
    text = " ".join(str(reward.__doc__).split())
    weights = RewardWeights()
    alone = math.floor(weights.lost / weights.worst_running)
    assert f"worst running costs of {alone} ms" in text
    assert f"whole scenario of {DURATION:g} s" in text


def test_signals_of_living_drives_stay_inside_the_bounds() -> None:
    """Erratic weights on the hardest scenarios; clipping is for drives that are breaking up."""
    motor, n = Motor.load("paper"), 48
    seeds = combine(np.arange(n, dtype=np.uint64), 11)
    rng = np.random.default_rng(0)
    signals = np.zeros((n, N_SIGNALS), dtype=np.float32)
    low, high = np.full(N_SIGNALS, np.inf), np.full(N_SIGNALS, -np.inf)
    for estimator in ("smo", "coupled"):
        factory = SimFactory(motor, DriveDesign(estimator=estimator))
        sims = factory.build(stress_1_scenarios(motor, seeds), twin=False)
        for _ in range(400):
            sim_run(sims, 25, rng.integers(0, 2, n).astype(np.float32), signals)
            alive = signals[sims["lost"] == 0]
            if len(alive) == 0:
                break
            low, high = np.fmin(low, alive.min(axis=0)), np.fmax(high, alive.max(axis=0))
    assert np.all(low >= LOW) and np.all(high <= HIGH)
    assert np.all(high - low > 0.02 * (HIGH - LOW)), "a component that never moves, or far too wide"


def test_bounds_hold_for_broken_values() -> None:
    broken = np.array([[np.nan], [np.inf], [-np.inf]], dtype=np.float32).repeat(N_SIGNALS, axis=1)
    kept = bounded(broken)
    assert np.array_equal(kept, [LOW, HIGH, LOW])
    assert np.isnan(broken[0, 0]), "the input is not changed"
