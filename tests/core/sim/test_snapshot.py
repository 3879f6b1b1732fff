"""All state of a drive is in its bytes: copies, pickles and files of it go on identically."""

import copy
import io
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, SIM, Array, sim_run, sim_start
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import Seeds
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.machine.motor import Motor

State = Callable[[Array], bytes]
Run = Callable[[Array, int], bytes]

N = 18


def seeds() -> Seeds:
    return np.arange(N, dtype=np.uint64)


def advance(sims: Array, periods: int, k_s: float = 0.4) -> bytes:
    """Run the drives; returns their signals."""
    obs = np.zeros((len(sims), SIGNAL_N), dtype=np.float32)
    sim_run(sims, periods, np.full(len(sims), k_s, np.float32), obs)
    return obs.tobytes()


@pytest.fixture
def run(state_bytes: State) -> Run:
    """Run the drives; the bytes of all their numbers and signals after it."""
    return lambda sims, periods: advance(sims, periods) + state_bytes(sims)


@pytest.fixture
def sims(motor: Motor) -> Array:
    """Random drives in the middle of their scenarios."""
    out = SimFactory(motor, DriveDesign()).build(stress_1_scenarios(motor, seeds()))
    advance(out, 700, 0.8)
    return out


def gaps(dtype: np.dtype[Any], path: str) -> list[str]:
    """Where a C struct has bytes that belong to no field."""
    found: list[str] = []
    end = 0
    for name in dtype.names or ():
        assert dtype.fields is not None
        field, offset = dtype.fields[name][:2]
        found += [f"{path} before {name}"] if offset != end else []
        found += gaps(field.subdtype[0] if field.subdtype else field, f"{path}.{name}")
        end = offset + field.itemsize
    return found + ([f"{path} at its end"] if dtype.names and end != dtype.itemsize else [])


def test_no_padding() -> None:
    """Every byte belongs to a field, so equal drives have equal bytes."""
    assert gaps(SIM, "sim_t") == []


def through_file(sims: Array) -> Array:
    file = io.BytesIO()
    np.save(file, sims.view(np.uint8))
    file.seek(0)
    return np.asarray(np.load(file, allow_pickle=False).view(SIM))


COPIES: dict[str, Callable[[Array], Array]] = {
    "copy": lambda s: s.copy(),
    "deepcopy": copy.deepcopy,
    "pickle": lambda s: np.asarray(pickle.loads(pickle.dumps(s))),
    "bytes": lambda s: np.frombuffer(s.tobytes(), dtype=SIM).copy(),
    "file": through_file,
}


@pytest.mark.parametrize("how", COPIES)
def test_a_copy_goes_on_identically(how: str, sims: Array, run: Run, state_bytes: State) -> None:
    """Original and copy end in the same bytes, and running one does not touch the other."""
    twin = COPIES[how](sims)
    before = state_bytes(twin)
    assert before == state_bytes(sims)
    end = run(sims, 500)
    assert state_bytes(twin) == before
    assert run(twin, 500) == end


def test_restore(sims: Array, run: Run) -> None:
    """Going back to a snapshot and forward again repeats the run."""
    snapshot = sims.copy()
    first = run(sims, 400)
    sims[...] = snapshot
    assert run(sims, 400) == first


def test_pieces(sims: Array, state_bytes: State) -> None:
    """One call of 300 periods and calls of 1, 99 and 200 end in the same drives."""
    twin = sims.copy()
    advance(sims, 300)
    for periods in (1, 99, 200):
        advance(twin, periods)
    for field in ("drive", "twin", "now", "k", "lost"):
        assert state_bytes(sims[field]) == state_bytes(twin[field])


def test_restart(sims: Array, motor: Motor, state_bytes: State) -> None:
    """sim_start forgets everything but the scenario."""
    fresh = SimFactory(motor, DriveDesign()).build(stress_1_scenarios(motor, seeds()))
    sims["err_count"], sims["lost"], sims["tau_1"], sims["dev_1"] = 7, 1, 1.0, 2.0
    assert state_bytes(sims) != state_bytes(fresh)
    sim_start(sims)
    assert state_bytes(sims) == state_bytes(fresh)


def test_the_comparison_can_fail(sims: Array, run: Run) -> None:
    """A change of one flux by 1e-6 is seen."""
    twin = sims.copy()
    twin["drive"]["y"]["psi_q"][3] += 1e-6
    assert run(twin, 300) != run(sims, 300)
