"""What a run shows over time: nothing hidden, everything named."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("matplotlib")

from sensorless.core.api import lib
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.words import plan_from
from sensorless.evaluation.trace import Trace, trace
from sensorless.machine.motor import Motor
from sensorless.plots.replayed import replayed
from sensorless.plots.wave import FOLDED, Curve, faults, merged, wave
from sensorless.plots.waveforms import waveforms
from sensorless.policies.registry import make_policy
from sensorless.report.picture import write_waves
from sensorless.units import RAD_S_TO_RPM
from tests.helpers.sample import replayed_sample

MOTOR = Motor.load("paper")


@pytest.fixture(scope="module")
def lost() -> Trace:
    """A start, then the observer alone at a shaft that a load turns back: lost, told, recovered."""
    plan = plan_from("0:30", "0:10", None, 0.5, MOTOR, 0, start=True)
    design = DriveDesign(estimator="smo", lost_lock="restart")
    return trace(make_policy("constant:0", MOTOR), plan, MOTOR, design, go_on=True)


def test_every_band_and_mark_is_named(lost: Trace) -> None:
    found = wave("run", lost)
    assert found.bands[0][2] == "start"
    assert found.bands[0][1] == pytest.approx(lost["t"][lost["starting"] > 0.0][-1])
    assert "recovery" in [what for _, _, what, _ in found.bands]
    n = int(np.sum(np.diff(lost["alarm"].astype(int), prepend=0) == 1))
    first = "alarm" if n == 1 else f"alarm, first of {n}"
    named = [what for _, what, _ in found.marks if what]
    assert named == ["lost", first] and len(found.marks) == 1 + n
    drawn = waveforms([found])
    texts = [text.get_text().strip() for text in drawn.axes[0].texts]
    assert {"start", "recovery", "lost", first} <= set(texts)


def test_an_angle_beyond_its_axis_is_said() -> None:
    """A start from the wrong pole: the axis is for what comes after."""
    found = []
    for off in (180.0, 0.0):
        plan = plan_from("0:0", "0:0", None, 0.3, MOTOR, 0, start=True, theta_err=off)
        t = trace(make_policy("eq25", MOTOR), plan, MOTOR, DriveDesign())
        (pane,) = (pane for pane in wave("run", t).panes if pane.key == "angle")
        assert pane.span is not None
        for name, key in {"HFI": "_hfi", "blend": "", "observer": "_smo"}.items():
            beyond = np.nanmax(np.abs(np.rad2deg(t[f"theta_e_err{key}"]))) > pane.span[1]
            assert (name in pane.label.partition("estimate")[2]) == beyond
            found.append((name, off, bool(beyond)))
    assert ("blend", 180.0, True) in found and ("blend", 0.0, False) in found


def test_panes_are_drawn_as_asked(lost: Trace) -> None:
    found = wave("run", lost)
    assert len(waveforms([found]).axes) == len(found.panes) - len(FOLDED)
    asked = waveforms([found], ["current", "faults"])
    labels = [line.get_label() for ax in asked.axes[-2:] for line in ax.lines]
    assert {"i_d", "i_q", "lock"} <= set(labels)


def test_a_long_title_stays_within_the_picture(lost: Trace) -> None:
    drawn = waveforms([wave(" ".join(["how it ended"] * 12), lost)])
    drawn.draw_without_rendering()
    box = drawn.axes[0].title.get_window_extent()
    assert 0.0 <= box.x0 and box.x1 <= drawn.bbox.width and box.y1 <= drawn.bbox.height


def test_a_fault_is_up_while_it_is_set(lost: Trace) -> None:
    (curve,) = (c for c in faults(lost["fault"]) if c.name == "lock")
    up = lost["fault"] & int(lib.FAULT_LOCK) != 0
    assert up.any() and not up.all()
    assert np.array_equal(curve.values % 1.0 > 0.5, up)


def test_a_drive_that_runs_away_hides_nothing_else() -> None:
    """What lies far beyond all that was judged is left out, in pictures and pages."""
    motor = replace(MOTOR, J=0.002)
    plan = plan_from("0:100", "0:33", None, 0.6, motor, 0)
    run = trace(make_policy("eq25", motor), plan, motor, DriveDesign(), go_on=True)
    found = wave("run", run)
    assert {what for _, what, _ in found.marks} == {"not feasible", "alarm"}
    before = RAD_S_TO_RPM * np.abs(run["omega_m"][~run["judged"]]).max()
    assert RAD_S_TO_RPM * np.abs(run["omega_m"]).max() > 10.0 * before
    for curve in found.panes[0].curves:
        assert np.nanmax(np.abs(curve.values)) < 4.0 * before
    own = next(c for c in found.panes[0].curves if c.name == "sensorless")
    assert np.isfinite(own.values[~run["judged"]]).all()


def test_the_same_curves_are_one_with_both_names() -> None:
    x = np.array([0.0, np.nan, 2.0])
    found = merged([Curve("a", "hfi", x), Curve("b", "own", x + 1e-6, 3.0), Curve("c", "ref", -x)])
    assert [(c.name, c.colour) for c in found] == [("a, b", "own"), ("c", "ref")]


@pytest.mark.parametrize("name", ["run.png", "run.html"])
def test_the_name_of_the_file_says_what_it_becomes(lost: Trace, tmp_path: Path, name: str) -> None:
    write_waves([wave("run & more", lost)], tmp_path / name, "sensorless simulate")
    head = (tmp_path / name).read_bytes()[:15]
    assert head.startswith(b"\x89PNG" if name.endswith("png") else b"<!DOCTYPE html>")


def test_of_a_replay_the_noisy_curve_lies_below_the_others() -> None:
    for pane in replayed(replayed_sample(), "sample").panes[:2]:
        known = [c for c in pane.curves if "encoder" not in c.name]
        noise = [float(np.nanstd(np.diff(curve.values))) for curve in known]
        assert noise[0] == max(noise), pane.key
