"""Settings that hold for all tests, and the machine, table and tools that several folders share."""

import functools
import gc
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")  # two threads of torch on a busy machine are slower
os.environ.setdefault("MPLBACKEND", "Agg")  # figures without a screen

import numpy as np
import pytest
import typer.main
import typer.testing

from sensorless import files
from sensorless.design.drive import DriveDesign
from sensorless.evaluation import aggregate, compare
from sensorless.export import fit, judge, selftest, vectors
from sensorless.export.export import Exported, export
from sensorless.machine import map_fit
from sensorless.machine.magnetics import Floats
from sensorless.machine.map_file import load_map
from sensorless.machine.map_fit import MapFit
from sensorless.machine.motor import Motor
from sensorless.pil.tools import missing_packages
from sensorless.plots import figure
from sensorless.table.ks_table import Axis, KsTable
from tests.helpers.machines import MEASURED_MAP, knee_map
from tests.helpers.objects import Failed, compiled, remove_unused
from tests.helpers.scenarios import at_most, briefly, lasting

SHIPPED_FLAGS, FULL_DPI, FULL_FIT = selftest.FLAGS, figure.DPI, fit.SIZE
WHOLE_RUN = vectors.DURATION
ALL_DRAWS = aggregate.RESAMPLES

gc.disable()  # until all tests are imported


@pytest.fixture(scope="session")
def motor() -> Motor:
    return Motor.load("paper")


@pytest.fixture(scope="session")
def design() -> DriveDesign:
    return DriveDesign()


@pytest.fixture(scope="session")
def table() -> KsTable:
    """Eq. 25 with bumps over the torque current: a table that uses both of its axes."""
    axes = (Axis("speed", 0.0, 0.5, 9), Axis("torque_current", -1.5, 1.5, 5))
    ramp = np.clip((0.27 - axes[0].nodes[:, None]) / 0.07, 0.0, 1.0)
    bumps = 0.1 * np.random.default_rng(5).standard_normal((9, 5))
    values = np.clip(ramp + np.where((ramp > 0) & (ramp < 1), bumps, 0.0), 0.0, 1.0)
    return KsTable(axes, values.astype(np.float32), provenance={"command": "train --seed 5"})


@pytest.fixture(scope="session")
def target() -> None:
    """Cross compiler and emulator are there; required where the environment says CI=true."""
    missing = missing_packages()
    if missing and os.environ.get("CI") == "true":
        pytest.fail(f"CI needs {', '.join(missing)}")
    if missing:
        pytest.skip(f"needs the Debian packages {', '.join(missing)}")


@pytest.fixture(scope="session")
def exported(
    tmp_path_factory: pytest.TempPathFactory, table: KsTable, motor: Motor, design: DriveDesign
) -> Exported:
    """An export of ``table``, as a user has it."""
    folder = tmp_path_factory.mktemp("export") / "made" / "here"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(vectors, "DURATION", WHOLE_RUN)
        return export(table, motor, design, folder, policy="trial")


def fitted(i: Floats, psi: Floats, start: int) -> MapFit:
    """Fit to a map of ``pmsyrm_5600w``, or of about that machine, from the start that wins."""
    machine = Motor.load("pmsyrm_5600w")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(map_fit, "STARTS", (map_fit.STARTS[start],))
        return map_fit.fit_map(i, psi, machine.i_rated, machine.i_max)


@pytest.fixture(scope="session")
def baldor() -> MapFit:
    """Fit to the measured flux map; the best of the three starts is the last."""
    return fitted(*load_map(MEASURED_MAP), -1)


@pytest.fixture(scope="session")
def knee() -> MapFit:
    """Fit to a map that the model cannot meet; all starts end at the same."""
    return fitted(*knee_map(), 0)


@pytest.fixture(scope="session", autouse=True)
def small() -> Iterator[None]:
    """What costs time and is not what a test is about, for all tests at once.

    Self tests on export compile without optimisation, against a short golden run but for
    ``whole_run``; ``identity`` compares the levels. Commands that end with a verdict run it on few
    short scenarios; ``test_compare`` on more. Intervals are of a tenth of the draws, but for
    ``all_draws``. Pictures are drawn with a third of their dots a side, where text falls: half the
    bytes, as those of all dots have a palette. Nothing waits for the disk.
    """
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(selftest, "FLAGS", (*SHIPPED_FLAGS, "-O0"))
        patch.setattr(vectors, "DURATION", 0.2)
        patch.setattr(judge, "SIZE", 8)
        patch.setattr(judge, "CHECKED", 2)
        patch.setattr(fit, "SIZE", 8)
        patch.setattr(compare, "SIZE", 8)
        patch.setattr(aggregate, "RESAMPLES", 200)
        patch.setattr(compare, "suite", lasting(0.1))
        patch.setattr(figure, "DPI", FULL_DPI // 3)
        patch.setattr(figure, "LAYOUT", None)
        patch.setattr(files, "sync", lambda path: None)  # test_files has its own
        yield


@pytest.fixture(scope="session", autouse=True)
def one_program() -> Iterator[None]:
    """The commands and their options are put together once, not at every call of the program."""
    made = functools.cache(typer.main.get_command)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(typer.main, "get_command", made)
        patch.setattr(typer.testing, "_get_command", made)
        yield


@pytest.fixture(scope="session", autouse=True)
def one_core() -> Iterator[None]:
    """Self tests on export compile the same core and tests with the same flags once."""
    remove_unused()
    whole = selftest.compile_program

    def compile_program(
        compiler: list[str], sources: list[Path], program: Path
    ) -> subprocess.CompletedProcess[str]:
        core = [path for path in sources if path.parent.name == "core"]
        tests = [path for path in sources if path.stem in ("arithmetic", "faults")]
        made = [path for path in sources if path not in [*core, *tests]]
        for more in ([], tests):
            found = compiled(core[0].parent, [*compiler, *selftest.FLAGS], *more)
            if isinstance(found, Failed):
                return found
            made += found
        return whole(compiler, made, program)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(selftest, "compile_program", compile_program)
        yield


@pytest.fixture
def brief() -> Iterator[None]:
    """As ``briefly``."""
    with briefly():
        yield


@pytest.fixture(scope="module")
def short_suites() -> Iterator[None]:
    """Scenarios of 0.6 s where a module is about what is said of them, for all of the module."""
    with at_most(0.6):
        yield


@pytest.fixture
def all_draws(monkeypatch: pytest.MonkeyPatch) -> None:
    """Intervals are those of the commands, as another process has them."""
    monkeypatch.setattr(aggregate, "RESAMPLES", ALL_DRAWS)


@pytest.fixture
def whole_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Golden vectors are of a run as long as a user's."""
    monkeypatch.setattr(vectors, "DURATION", WHOLE_RUN)


@pytest.fixture
def without_ekf(monkeypatch: pytest.MonkeyPatch) -> None:
    """The Kalman filter of a replay, which takes most of its time, diverges at once."""

    def run_ekf(motor: object, u: Floats, i: Floats, *start: float) -> tuple[Floats, Floats]:
        return np.full(len(u), np.nan), np.full(len(u), np.nan)

    monkeypatch.setattr("sensorless.replay.replay.run_ekf", run_ekf)


@pytest.fixture
def without_selftest(monkeypatch: pytest.MonkeyPatch) -> None:
    """Exports are written as where there is no compiler; the target runs their tests, or others."""
    monkeypatch.setattr(selftest, "find_compiler", lambda: None)


def pytest_collection_finish() -> None:
    """What the imports left is never searched for garbage; the rest, seldom."""
    gc.freeze()
    gc.set_threshold(100_000)
    gc.enable()
