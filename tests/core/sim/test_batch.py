"""Blocks of vector code and threads change how fast a drive is simulated, never its numbers."""

from collections.abc import Callable
from functools import cache
from time import process_time
from typing import Any

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_N, Array, lib, sim_run
from sensorless.design.drive import ESTIMATORS, DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.stress import stress_1_scenarios, stress_scenarios
from sensorless.machine.motor import Motor

Bytes = Callable[[Array], bytes]
Call = Callable[..., None]

IN_BLOCKS = ("smo", "flux", "coupled")
ODD = {
    ("sensored",): 1,
    ("with_twin",): 0,
    ("plant", "detail"): 1,
    ("plant", "n_sub"): 2,
    ("plant", "extra"): 1,
    ("inv_stick",): 0.5,
    ("sensor", "carrier"): 1,
    ("control", "hfi", "scheme"): lib.HFI_STATIONARY,
    ("control", "smo", "switching"): lib.SMO_SIGN,
}
"""Fields of ``sim_t`` and the value that needs a path that blocks do not have."""
SIZES = (1, 3, 4, 15, 16, 17, 68)
MOST = max(SIZES)
WEIGHTS = np.clip(1.3 * (0.618 * np.arange(MOST) % 1.0) - 0.15, 0.0, 1.0).astype(np.float32)
"""Both ends and between, however few the drives."""
PERIODS = 1600


@cache
def drives(twin: bool, estimator: str, detail: bool = False) -> Array:
    """Random drives of which some are over before the run, some end in it, and some get lost."""
    motor = Motor.load("paper")
    draw = stress_scenarios if detail else stress_1_scenarios
    sims = SimFactory(motor, DriveDesign(estimator=estimator)).build(
        draw(motor, np.arange(MOST, dtype=np.uint64)), twin=twin
    )
    assert (sims["plant"]["detail"] == detail).all()
    sims["err_limit"][2::5] *= 0.06  # the flux observer loses few
    sims["k_end"][1::5] = 40 * np.arange(len(sims["k_end"][1::5]))
    return sims


def advance(
    n: int, twin: bool, estimator: str, detail: bool = False, **how: Any
) -> tuple[Array, Array]:
    """Run the first n drives, each with a weight of its own; drives and signals after it."""
    sims = drives(twin, estimator, detail)[:n].copy()
    obs = np.zeros((n, SIGNAL_N), dtype=np.float32)
    sim_run(sims, PERIODS, WEIGHTS[:n], obs, **how)
    return sims, obs


@cache
def all_plainly(twin: bool, estimator: str, detail: bool) -> tuple[Array, Array]:
    return advance(MOST, twin, estimator, detail, simd=lib.SIMD_NONE, threads=1)


def plainly(n: int, twin: bool, estimator: str, detail: bool = False) -> tuple[Array, Array]:
    """What the plain loop, which takes them one by one, makes of the first n drives."""
    sims, obs = all_plainly(twin, estimator, detail)
    return sims[:n], obs[:n]


@pytest.mark.parametrize("estimator", IN_BLOCKS)
def test_blocks_are_vector_code(estimator: str) -> None:
    """A jump that the compiler cannot turn into a selection would make them as slow as the loop."""
    if lib.sim_simd() == lib.SIMD_NONE:
        pytest.skip("this processor or compiler has no vector code")
    start = drives(True, estimator)[:64].copy()
    start["err_limit"], start["k_end"] = 1e9, 2 * PERIODS
    took = {lib.SIMD_NONE: np.inf, lib.sim_simd(): np.inf}
    obs = np.zeros((64, SIGNAL_N), dtype=np.float32)
    for _ in range(3):
        for level in took:
            sims, begin = start.copy(), process_time()
            sim_run(sims, 400, WEIGHTS[:64], obs, simd=level, threads=1)
            took[level] = min(took[level], process_time() - begin)
    assert took[lib.SIMD_NONE] > 2.0 * took[lib.sim_simd()]


@pytest.mark.parametrize("detail", [False, True], ids=["plain", "detail"])
@pytest.mark.parametrize("estimator", IN_BLOCKS)
@pytest.mark.parametrize("twin", [True, False], ids=["twin", "alone"])
@pytest.mark.parametrize("simd", ["SIMD_AVX2", "SIMD_AVX512"])
def test_blocks_equal_the_plain_loop(
    simd: str, twin: bool, estimator: str, detail: bool, state_bytes: Bytes
) -> None:
    level = getattr(lib, simd)
    if lib.sim_simd() < level:
        pytest.skip(f"this processor or compiler has no {simd}")
    for n in SIZES:
        sims, obs = advance(n, twin, estimator, detail, simd=level, threads=1)
        expected, signals = plainly(n, twin, estimator, detail)
        assert obs.tobytes() == signals.tobytes(), n
        assert state_bytes(sims) == state_bytes(expected), n


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("threads", [1, 2, 3, 7])
def test_any_number_of_threads(threads: int, n: int, state_bytes: Bytes) -> None:
    sims, obs = advance(n, True, "smo", threads=threads)
    expected, signals = plainly(n, True, "smo")
    assert obs.tobytes() == signals.tobytes()
    assert state_bytes(sims) == state_bytes(expected)


@pytest.mark.parametrize("estimator", IN_BLOCKS)
def test_the_drives_are_worth_comparing(estimator: str) -> None:
    """Some survive, some get lost in the run, some end in it, at different periods."""
    sims, _ = plainly(MOST, True, estimator)
    lost = sims["lost"] != 0
    assert 4 < lost.sum() < 60
    assert len(np.unique(sims["k"][lost])) > 4
    assert (sims["k"] == PERIODS).sum() > 30
    assert len(np.unique(sims["k"][(sims["k"] == sims["k_end"]) & ~lost])) > 5


def test_mixed_drives_run_one_by_one(state_bytes: Bytes) -> None:
    """A block holds one kind of drive; others beside it do not change its results."""
    sims = drives(True, "smo")[:32].copy()
    sims["with_twin"][3], sims["sensored"][20] = 0, 1
    sims["control"]["estimator"][5] = lib.ESTIMATE_FLUX
    expected = sims.copy()
    k_s, obs = np.full(32, 0.6, np.float32), np.zeros((32, SIGNAL_N), np.float32)
    sim_run(sims, 400, k_s, obs)
    sim_run(expected, 400, k_s, obs, plain=True)
    assert state_bytes(sims) == state_bytes(expected)


@pytest.mark.parametrize("estimator", ESTIMATORS)
def test_which_drives_run_as_blocks(c: Call, estimator: str) -> None:
    """Those on either observer, as fast as the machine allows; all of them on the same one."""
    found = np.empty(1, np.int32)
    sims = drives(True, estimator)[:16].copy()
    c("batch_fits", sims, 16, found)
    assert found[0] == (lib.sim_simd() if estimator in IN_BLOCKS else lib.SIMD_NONE)
    for other in set(ESTIMATORS) - {estimator}:
        sims["control"]["estimator"][7] = ESTIMATORS[other]
        c("batch_fits", sims, 16, found)
        assert found[0] == lib.SIMD_NONE


def test_drives_that_are_not_in_control_advance_beside_the_block(c: Call) -> None:
    """A block needs four that are."""
    found = np.empty(1, np.int32)
    sims = drives(True, "smo")[:16].copy()
    for waiting, level in ((12, lib.sim_simd()), (13, lib.SIMD_NONE)):
        sims["drive"]["x"]["start"]["phase"][:waiting] = lib.START_CATCH
        c("batch_fits", sims, 16, found)
        assert found[0] == level


@pytest.mark.parametrize("path", ODD)
def test_what_vector_code_leaves_out_is_not_in_a_block(c: Call, path: tuple[str, ...]) -> None:
    """One drive with a path of its own keeps all of them out."""
    found = np.empty(1, np.int32)
    sims = drives(True, "smo")[:16].copy()
    record = sims
    for name in path[:-1]:
        record = record[name]
    record[path[-1]][9] = ODD[path]
    c("batch_fits", sims, 16, found)
    assert found[0] == lib.SIMD_NONE
    record[path[-1]][9] = record[path[-1]][8]
    c("batch_fits", sims, 16, found)
    assert found[0] == lib.sim_simd()
