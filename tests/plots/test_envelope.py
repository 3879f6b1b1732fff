"""The map of where lock holds: what its title counts."""

import math

import numpy as np

from sensorless.evaluation.results import Envelope


def grid(lost: list[bool], causes: list[str | None]) -> Envelope:
    return Envelope.of({"lost": lost, "lost_cause": causes, "angle_err_rms_deg": [1.0] * 4})


def test_points_beyond_the_machine_are_neither_held_nor_lost() -> None:
    """Three of four points are feasible, and two of them hold."""
    found = grid([False, True, False, False], [None, "angle", "twin", None])
    assert np.isclose(found.held_pct, 200.0 / 3.0)
    assert math.isnan(grid([False] * 4, ["twin"] * 4).held_pct)
