"""Random words as inputs: the same outputs from target and host, and always numbers."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from sensorless.core.api import lib
from sensorless.export.export import Exported
from sensorless.pil.device import DRIVE_IN, DRIVES, Device, Operation, start_items
from sensorless.pil.lockstep import canonical
from sensorless.pil.tools import build, qemu_command

ODD = np.array(
    [np.nan, -np.nan, np.inf, -np.inf, 3.4e38, -3.4e38, 1e-45, -1e-40, -0.0, 0.0, 1.0, -1.0],
    dtype=np.float32,
)


@pytest.mark.usefixtures("target")
def test_target_and_host_react_alike(
    exported: Exported, tmp_path: Path, kept_objects: Callable[..., Path]
) -> None:
    image = kept_objects(exported.folder, tmp_path / "target", "image")
    program = build(exported.folder, tmp_path / "host", "host", "-O0")
    rng = np.random.default_rng(11)
    seam = np.tile(np.array([np.pi, -np.pi, 3.1415925, 0.0], dtype=np.float32), DRIVES // 4)
    seek = np.arange(DRIVES) % 2 == 1
    begin = start_items(seam, rng.uniform(-700.0, 700.0, DRIVES), rng.random(DRIVES), seek)
    with Device(qemu_command(image), tmp_path) as target, Device([str(program)]) as host:
        target.ask(Operation.START, begin)
        host.ask(Operation.START, begin)
        for _ in range(60):
            words = rng.integers(0, 2**32, (DRIVES, 5), dtype=np.uint32).view(np.float32)
            sane = rng.uniform([-9, -9, 400, -700, 0], [9, 9, 600, 700, 1], (DRIVES, 5))
            inputs = np.where(rng.random((DRIVES, 5)) < 0.2, words, sane.astype(np.float32))
            inputs = np.where(rng.random((DRIVES, 5)) < 0.2, rng.choice(ODD, (DRIVES, 5)), inputs)
            items = np.ascontiguousarray(inputs, dtype=np.float32).view(DRIVE_IN)[:, 0]
            a, b = target.ask(Operation.RAW, items), host.ask(Operation.RAW, items)
            wa, wb = (x.view(np.uint32).reshape(DRIVES, -1)[:, :-2] for x in (a, b))
            assert np.array_equal(canonical(wa), canonical(wb))
            assert all(np.isfinite(a[part][axis]).all() for part in "u" for axis in "ab")
            assert np.isfinite(a["x"]["est"]["theta"]).all()
            assert ((a["x"]["k_s"] >= 0.0) & (a["x"]["k_s"] <= 1.0)).all()
        bad = lib.FAULT_CURRENT | lib.FAULT_U_DC | lib.FAULT_COMMAND
        from_currents = lib.FAULT_OVER_CURRENT | lib.FAULT_LOCK
        assert (a["x"]["fault"] & bad == bad).all()
        assert (a["x"]["fault"][~seek] & ~(bad | from_currents) == 0).all()
