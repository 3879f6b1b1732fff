"""The map of where lock holds: what its title counts, and that all text is on the picture."""

import math
from itertools import combinations

import numpy as np
import pytest

from sensorless.evaluation.results import Envelope, Results
from sensorless.machine.motor import Motor
from sensorless.plots import figure as figures
from sensorless.plots.envelope import envelope_maps


def grid(lost: list[bool], causes: list[str | None]) -> Envelope:
    return Envelope.of({"lost": lost, "lost_cause": causes, "angle_err_rms_deg": [1.0] * 4})


def test_points_beyond_the_machine_are_neither_held_nor_lost() -> None:
    """Three of four points are feasible, and two of them hold."""
    found = grid([False, True, False, False], [None, "angle", "twin", None])
    assert np.isclose(found.held_pct, 200.0 / 3.0)
    assert math.isnan(grid([False] * 4, ["twin"] * 4).held_pct)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_no_text_leaves_the_picture_or_hides_another(
    n: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    monkeypatch.setattr(figures, "LAYOUT", "constrained")
    names = [f"rule-{j}-of-the-speed-and-the-load-with-a-name-of-SOME-LENGTH" for j in range(n)]
    points = {"lost": [False] * 4, "lost_cause": [None] * 4, "angle_err_rms_deg": [1.0] * 4}
    policies = {name: {"scenarios": points} for name in names}
    results = Results("envelope", 1, 4, "paper", "", {}, {}, policies, {})
    drawn = envelope_maps(results, Motor.load("paper"))
    drawn.draw_without_rendering()
    maps = drawn.axes[:n]
    titles = [ax.title.get_window_extent() for ax in maps]
    for box in (drawn.legends[0].get_window_extent(), *titles):
        assert 0.0 <= box.x0 < box.x1 <= drawn.bbox.x1 and 0.0 <= box.y0 < box.y1 <= drawn.bbox.y1
    boxes = [drawn.legends[0].get_window_extent(), *titles, *(ax.bbox for ax in maps)]
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))
    assert "".join(maps[0].get_title().split("\n")[:-1]) == names[0]
