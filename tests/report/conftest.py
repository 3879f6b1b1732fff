"""A finished training run to report on."""

from pathlib import Path

import numpy as np
import pytest

from sensorless.machine.motor import Motor
from sensorless.table.ks_table import Axis, KsTable

CURVE = "steps,seconds,lost_rate,torque_dev,torque_ripple,objective,best\n" + "".join(
    f"{1000 * j},{20.0 * j},{0.04 - 0.01 * j},0.06,0.017,{0.5 - 0.1 * j},1\n" for j in range(4)
)


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run folder as training leaves it, with a table of three axes."""
    folder = tmp_path_factory.mktemp("runs") / "mine & yours"
    folder.mkdir()
    axes = (
        Axis("speed", 0.0, 1.0, 5),
        Axis("torque_current", -1.5, 1.5, 3),
        Axis("disagreement", -1.0, 1.0, 3),
    )
    values = np.broadcast_to(np.linspace(1.0, 0.0, 5)[:, None, None], (5, 3, 3))
    KsTable(axes, np.ascontiguousarray(values, dtype=np.float32)).save(
        folder / "table.json",
        {
            "motor_digest": Motor.load("paper").digest,
            "command": "sensorless train --name <mine>",
            "steps": 4000,
            "seed": 3,
            "versions": {"torch": "9.9"},
        },
    )
    (folder / "progress.csv").write_text(CURVE)
    (folder / "verdict.json").write_text('{"verdict": "better than its start"}')
    return folder
