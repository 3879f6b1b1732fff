"""All state of a drive is in its bytes: copies, pickles and files of it go on identically."""

import copy
import io
import pickle
from collections.abc import Callable

import numpy as np
import pytest

from sensorless.core_api import SIGNAL_N, SIM, Array, sim_run, sim_start
from sensorless.drive import DriveDesign
from sensorless.envs.scenario import SimFactory
from sensorless.envs.stress import stress_scenarios
from sensorless.motor import Motor

N = 18


def run(sims: Array, periods: int, k_s: float = 0.4) -> bytes:
    """Advance; the bytes of drives and observations after it."""
    obs = np.zeros((len(sims), SIGNAL_N), dtype=np.float32)
    sim_run(sims, periods, np.full(len(sims), k_s, np.float32), obs)
    return sims.tobytes() + obs.tobytes()


@pytest.fixture
def sims(motor: Motor) -> Array:
    """Random drives in the middle of their scenarios."""
    out = SimFactory(motor, DriveDesign()).build(stress_scenarios(motor, np.arange(N, dtype=np.uint64)))
    run(out, 700, 0.8)
    return out


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
def test_a_copy_goes_on_identically(how: str, sims: Array) -> None:
    """Original and copy end in the same bytes, and running one does not touch the other."""
    twin = COPIES[how](sims)
    before = twin.tobytes()
    assert before == sims.tobytes()
    end = run(sims, 500)
    assert twin.tobytes() == before
    assert run(twin, 500) == end


def test_restore(sims: Array) -> None:
    """Going back to a snapshot and forward again repeats the run."""
    snapshot = sims.copy()
    first = run(sims, 400)
    sims[...] = snapshot
    assert run(sims, 400) == first


def test_pieces(sims: Array) -> None:
    """One call of 300 periods and calls of 1, 99 and 200 end in the same drives."""
    twin = sims.copy()
    run(sims, 300)
    for periods in (1, 99, 200):
        run(twin, periods)
    for field in ("drive", "twin", "now", "k", "lost"):
        assert sims[field].tobytes() == twin[field].tobytes()


def test_restart(sims: Array) -> None:
    """sim_start forgets everything but the scenario."""
    fresh = sims.copy()
    sim_start(fresh)
    run(sims, 100)
    sim_start(sims)
    assert np.all(sims["k"] == 0)
    assert run(sims, 200) == run(fresh, 200)


def test_the_comparison_can_fail(sims: Array) -> None:
    """A change of the last bit of one current is seen."""
    twin = sims.copy()
    twin["drive"]["y"]["psi_q"][3] = np.nextafter(twin["drive"]["y"]["psi_q"][3], 9.0)
    assert run(twin, 300) != run(sims, 300)
