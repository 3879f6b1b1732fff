"""The measurement noise: its moments, and that it is a function of seed and counter alone."""

from collections.abc import Callable

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, sim_run
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import Scenarios, SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.machine.magnetics import Floats
from sensorless.machine.motor import Motor

Call = Callable[..., None]
Words = np.ndarray[tuple[int], np.dtype[np.uint32]]

N = 400_000


def noise(c: Call, seed: Words, counter: Words) -> Floats:
    y = np.empty(len(seed), dtype=np.float32)
    c("noise", np.ascontiguousarray(seed), np.ascontiguousarray(counter), y, len(y))
    return y.astype(float)


def counters(n: int = N) -> Words:
    return np.arange(n, dtype=np.uint32)


@pytest.mark.parametrize("seed", [0, 1, 12345, 0xFFFFFFFF])
def test_moments(c: Call, seed: int) -> None:
    """Mean 0, variance 1, kurtosis -0.3, never beyond 3.47."""
    y = noise(c, np.full(N, seed, dtype=np.uint32), counters())
    assert abs(np.mean(y)) < 4.0 / np.sqrt(N)
    assert np.var(y) == pytest.approx(1.0, abs=0.01)
    assert np.mean(y**4) / np.var(y) ** 2 - 3.0 == pytest.approx(-0.3, abs=0.03)
    assert np.max(np.abs(y)) < 3.47


@pytest.mark.parametrize("lag", [1, 2, 3, 7])
def test_white(c: Call, lag: int) -> None:
    """Neighbouring samples and the two channels do not depend on each other."""
    y = noise(c, np.full(N, 77, dtype=np.uint32), counters())
    assert abs(np.mean(y[lag:] * y[:-lag])) < 5.0 / np.sqrt(N)


def test_seeds_differ(c: Call) -> None:
    """Neighbouring seeds give unrelated numbers."""
    a, b = (noise(c, np.full(N, s, dtype=np.uint32), counters()) for s in (8, 9))
    assert abs(np.mean(a * b)) < 5.0 / np.sqrt(N)
    across = noise(c, counters(), np.zeros(N, dtype=np.uint32))
    assert abs(np.mean(across)) < 5.0 / np.sqrt(N)
    assert np.var(across) == pytest.approx(1.0, abs=0.01)


def test_order_of_calls_does_not_matter(c: Call) -> None:
    """Number j is the same whatever was drawn before it."""
    order = np.random.default_rng(0).permutation(1000).astype(np.uint32)
    seed = np.full(1000, 5, dtype=np.uint32)
    straight = noise(c, seed, counters(1000))
    assert np.array_equal(noise(c, seed, order), straight[order])


def test_a_drive_does_not_depend_on_its_batch(
    motor: Motor, state_bytes: Callable[[Array], bytes]
) -> None:
    """The same scenario gives the same numbers alone, in a batch, and in another order."""
    scenarios = stress_1_scenarios(motor, np.arange(20, dtype=np.uint64))
    factory = SimFactory(motor, DriveDesign())

    def run(s: Scenarios) -> list[bytes]:
        sims = factory.build(s)
        sim_run(
            sims, 300, np.full(len(s), 0.7, np.float32), np.empty((len(s), SIGNAL_N), np.float32)
        )
        return [state_bytes(sims[j : j + 1]) for j in range(len(s))]

    whole = run(scenarios)
    backwards = run(scenarios[::-1])
    assert len(set(whole)) == 20
    for j in range(20):
        assert whole[j] == backwards[19 - j]
        assert whole[j] == run(scenarios[j : j + 1])[0]
