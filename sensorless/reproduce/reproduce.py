"""Reruns the figures and claims of the source paper (doi 10.12177/emca.2025.011)."""

from collections.abc import Callable, Sequence
from pathlib import Path

from sensorless.files import check_folder, ensure_writable, write_atomic
from sensorless.machine.motor import Motor
from sensorless.plots.figure import save
from sensorless.reproduce.case import Case
from sensorless.reproduce.dynamic import abstract, figure_9, figure_13
from sensorless.reproduce.layer import boundary_layer
from sensorless.reproduce.page import data, markdown
from sensorless.reproduce.printed import printed, timing
from sensorless.reproduce.signum import figure_12
from sensorless.reproduce.steady import figure_4, figure_11
from sensorless.reproduce.switching import switching

PAGE, DATA = "paper.md", "paper.json"
Progress = Callable[[float], None]
"""Called with the share done, 0 to 1."""


def cases(motor: Motor, progress: Progress | None = None) -> list[Case]:
    """Run all cases, in the order of the page."""
    report = progress or (lambda done: None)
    out = []
    for j, build in enumerate((figure_4, figure_11, figure_12)):
        out.append(build(motor))
        report((j + 1) / 6)
    nine, steps = figure_9(motor)
    report(4 / 6)
    thirteen, ramps = figure_13(motor)
    report(5 / 6)
    twelve = out[2]
    out = [out[0], nine, out[1], twelve, thirteen, switching(motor)]
    out += [abstract(steps, ramps, twelve), timing(motor), boundary_layer(motor), printed(motor)]
    report(1.0)
    return out


def reproduce(folder: Path, progress: Progress | None = None) -> list[Path]:
    """Write ``paper.md``, ``paper.json`` and the pictures into a folder; return the files.

    Raises
    ------
    UserError
        The folder cannot be written to, or matplotlib is missing.
    """
    check_folder(folder)
    motor = Motor.load("paper")
    return write(cases(motor, progress), motor, folder)


def write(done: Sequence[Case], motor: Motor, folder: Path) -> list[Path]:
    """Write what was run into a folder; return the files."""
    ensure_writable(folder)
    files = []
    for case in done:
        if case.figure is not None:
            files.append(folder / f"{case.name}.png")
            save(case.figure, files[-1])
    for name, text in ((PAGE, markdown(done, motor)), (DATA, data(done, motor))):
        files.append(folder / name)
        write_atomic(files[-1], text)
    return files
