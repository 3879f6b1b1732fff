"""Talks to a program that runs the exported control core, on the emulated target or on the host.

Operations and layouts come from ``firmware/pil_wire.h``, through the compiled core. Questions and
answers are NumPy arrays.
"""

import os
import select
import subprocess
import time
from collections.abc import Sequence
from enum import IntEnum
from pathlib import Path
from types import TracebackType

import numpy as np

from sensorless.core.api import SIGNAL_N, SIGNAL_NAMES, Array, lib, struct_dtype
from sensorless.errors import UserError
from sensorless.table.axis import Axis

DRIVES: int = lib.PIL_DRIVES
"""Most drives, or lookups, in one request."""


class Operation(IntEnum):
    """Requests that a device answers."""

    EXIT = lib.PIL_EXIT
    INFO = lib.PIL_INFO
    TESTS = lib.PIL_TESTS
    START = lib.PIL_START
    STEP = lib.PIL_STEP
    RAW = lib.PIL_RAW
    LOOKUP = lib.PIL_LOOKUP
    STAGES = lib.PIL_STAGES


DRIVE_IN = struct_dtype("drive_in_t")
STEP_ANSWER = struct_dtype("pil_step_t")
START_ITEM = struct_dtype("pil_start_t")
ANSWERS = {
    Operation.INFO: struct_dtype("pil_info_t"),
    Operation.TESTS: struct_dtype("pil_tests_t"),
    Operation.START: STEP_ANSWER,
    Operation.STEP: STEP_ANSWER,
    Operation.RAW: STEP_ANSWER,
    Operation.LOOKUP: struct_dtype("pil_lookup_t"),
    Operation.STAGES: struct_dtype("pil_stages_t"),
}


PATIENCE = 60.0
"""Longest wait for an answer [s]."""


class Device:
    """A running program; use it in a ``with`` statement.

    Parameters
    ----------
    command : list of str
    folder : Path, optional
        Folder for two pipes with the names that the target opens; without it the program talks over
        its standard input and output.
    """

    def __init__(self, command: list[str], folder: Path | None = None) -> None:
        self.name = Path(command[0]).name
        if folder is None:
            self._process = subprocess.Popen(
                command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
            )
            assert self._process.stdin is not None and self._process.stdout is not None
            self._to, self._from = self._process.stdin.fileno(), self._process.stdout.fileno()
            self._own: tuple[int, ...] = ()
        else:
            ends = []
            for name in ("to_target", "to_host"):
                (folder / name).unlink(missing_ok=True)
                os.mkfifo(folder / name)
                ends.append(os.open(folder / name, os.O_RDWR))  # does not wait for the other end
            self._to, self._from = ends
            self._own = tuple(ends)
            self._process = subprocess.Popen(
                command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                stderr=subprocess.PIPE,
            )  # fmt: skip

    def __enter__(self) -> "Device":
        """Return the device itself."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the program."""
        try:
            if kind is None:
                self._send(Operation.EXIT, 0, b"")
                self._process.wait(5.0)
        except (OSError, UserError, subprocess.TimeoutExpired):
            pass
        finally:
            self._process.kill()
            self._process.wait()
            for stream in (self._process.stdin, self._process.stdout, self._process.stderr):
                if stream is not None:
                    stream.close()
            for end in self._own:
                os.close(end)

    def ask(self, operation: Operation, items: Array | None = None) -> Array:
        """Send a request and wait for its answers: one per row of ``items``, or a single one."""
        self.send(operation, items)
        return self.receive(operation, 1 if items is None else len(items))

    def send(self, operation: Operation, items: Array | None = None) -> None:
        """Send a request; the device works while the caller does something else."""
        n = 0 if items is None else len(items)
        self._send(operation, n, b"" if items is None else np.ascontiguousarray(items).tobytes())

    def receive(self, operation: Operation, n: int) -> Array:
        """Receive the answers to a request, shape (n,)."""
        dtype = ANSWERS[operation]
        data = bytearray()
        while len(data) < n * dtype.itemsize:
            data += self._read(n * dtype.itemsize - len(data))
        return np.frombuffer(bytes(data), dtype=dtype)

    def _send(self, operation: Operation, n: int, data: bytes) -> None:
        data = np.array([operation, n], dtype=np.uint32).tobytes() + data
        while data:
            data = data[os.write(self._to, data) :]

    def _read(self, n: int) -> bytes:
        """Wait for bytes and return at most n of them."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            if select.select([self._from], [], [], 0.5)[0]:
                data = os.read(self._from, n)
                if data:
                    return data
            if self._process.poll() is not None:
                raise UserError(
                    f"pil: {self.name} stopped early with status {self._process.returncode}"
                    f"{self._last_words()}"
                )
        raise UserError(
            f"pil: {self.name} did not answer within {PATIENCE:g} s; run again on an idle computer"
        )

    def _last_words(self) -> str:
        text = self._process.stderr.read().decode(errors="replace") if self._process.stderr else ""
        lines = text.strip().splitlines()
        return f" ({lines[-1]})" if lines else ""


def start_items(theta: Array, omega: Array, k_s: Array, seek: Array) -> Array:
    """Starts of drives as START_ITEM (n,): angle [rad], electrical speed [rad/s] and weight.

    ``seek`` starts with the start sequence.
    """
    items = np.zeros(len(theta), dtype=START_ITEM)
    items["theta"], items["omega"], items["k_s"], items["seek"] = theta, omega, k_s, seek
    return items


def lookup_items(rng: np.random.Generator, table_axes: Sequence[Axis]) -> Array:
    """Signals (n, SIGNAL_N) inside, outside and at the ends of a table's axes, some not finite."""
    y = np.zeros((1024, SIGNAL_N), dtype=np.float32)
    odd = np.array([np.nan, np.inf, -np.inf, 3e38, -3e38, 1e-41, -0.0], dtype=np.float32)
    for axis in table_axes:
        width = axis.hi - axis.lo
        x = rng.uniform(axis.lo - 0.3 * width, axis.hi + 0.3 * width, len(y)).astype(np.float32)
        x[rng.random(len(y)) < 0.1] = axis.lo
        x[rng.random(len(y)) < 0.1] = axis.hi
        strange = rng.random(len(y)) < 0.05
        x[strange] = rng.choice(odd, strange.sum())
        y[:, SIGNAL_NAMES.index(axis.signal)] = x
    return y
