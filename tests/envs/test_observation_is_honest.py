"""A policy sees only what firmware can know: the observation depends on the drive's state alone."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sensorless.core.api import Array, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.blend_vector_env import BlendVectorEnv
from sensorless.envs.counter_random import combine
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.envs.signals import N_SIGNALS
from sensorless.machine.motor import Motor

CORE = Path(__file__).parents[2] / "core"
DRIVE = CORE / "drive"


def scramble(record: Array) -> None:
    """Overwrite every number of a record field."""
    names = record.dtype.names
    if names is None:
        record[...] = 17
        return
    for name in names:
        scramble(record[name])


def lie_about_plant(sims: Array) -> None:
    scramble(sims["drive"]["y"])


def lie_about_twin(sims: Array) -> None:
    scramble(sims["twin"])


def lie_about_scenario(sims: Array) -> None:
    for name in ("plant", "sensor", "profile", "now", "start"):
        scramble(sims[name])


def lie_about_drive(sims: Array) -> None:
    scramble(sims["drive"]["x"]["signal"])


def running_drives() -> Array:
    motor, n = Motor.load("paper"), 4
    seeds = combine(np.arange(n, dtype=np.uint64), 5)
    sims = SimFactory(motor, DriveDesign()).build(stress_1_scenarios(motor, seeds))
    sim_run(sims, 1000, np.full(n, 0.7, np.float32), np.zeros((n, N_SIGNALS), np.float32))
    return sims


def read(sims: Array, periods: int = 0) -> Array:
    signals = np.zeros((len(sims), N_SIGNALS), dtype=np.float32)
    sim_run(sims, periods, np.full(len(sims), 0.3, np.float32), signals)
    return signals


@pytest.mark.parametrize(
    ("lie", "seen"),
    [
        (lie_about_plant, False),
        (lie_about_twin, False),
        (lie_about_scenario, False),
        (lie_about_drive, True),
    ],
)
def test_the_truth_does_not_reach_the_observation(lie: Callable[[Array], None], seen: bool) -> None:
    sims = running_drives()
    honest = read(sims.copy())
    lie(sims)
    assert np.array_equal(read(sims), honest) is not seen


def test_nor_does_it_over_time() -> None:
    """Drives go on with a false label on the true angle, a false load count and no twin."""
    sims = running_drives()
    other = sims.copy()
    other["drive"]["y"]["theta_e"] += 0.5  # its sine and cosine, which the plant uses, stay
    other["drive"]["y"]["turns"] += 3
    other["with_twin"] = 0
    for _ in range(50):
        assert np.array_equal(read(sims, 5), read(other, 5))
    assert np.all(sims["sums"]["err_sq"] != other["sums"]["err_sq"])


def test_environment_shows_those_signals_and_nothing_else() -> None:
    env = BlendVectorEnv(4)
    env.reset(seed=3)
    for _ in range(20):
        env.step(np.zeros((4, 1)))
    state = env.state()
    honest = env.step(np.zeros((4, 1)))
    state.sims["drive"]["y"]["theta_e"] += 0.5
    state.sims["with_twin"] = 0
    state.constant[:] = 7.0
    env.restore(state)
    false = env.step(np.zeros((4, 1)))
    assert np.array_equal(honest[0], false[0])
    assert not np.array_equal(honest[4]["privileged"], false[4]["privileged"])


def test_what_the_firmware_compiles_knows_no_plant() -> None:
    shipped = {path.name for path in DRIVE.iterdir()}
    for path in DRIVE.glob("*.[ch]"):
        assert set(re.findall(r'#include "(\S+)"', path.read_text(encoding="utf-8"))) <= shipped
    code = (DRIVE / "signals.h").read_text(encoding="utf-8")
    code = re.sub(r"/\*.*?\*/", "", code, flags=re.S)
    assert not re.findall(r"plant|twin|truth|sums|tau|theta_e\b|omega_m\b", code)


def test_signals_are_filled_from_the_sensorless_drive_alone() -> None:
    """The arguments of what fills and reads signals name no truth, wherever it is called."""
    calls = []
    for path in sorted(CORE.glob("*/*.[ch]")):
        text = path.read_text(encoding="utf-8")
        calls += re.findall(
            r"^ .*\b(?:signals_read|signal_at|drive_signals)\(([^;]*)\);", text, flags=re.M
        )
    assert len(calls) >= 5
    for arguments in calls:
        assert not re.findall(r"plant|twin|sums|->y\b|\.y\b", arguments), arguments
