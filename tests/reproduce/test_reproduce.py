"""The page of the reproduction: all of it there, three columns, nothing that is not a number."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sensorless.errors import UserError
from sensorless.reproduce.case import Case, Row, row_of
from sensorless.reproduce.layer import STRAIGHT
from sensorless.reproduce.reproduce import reproduce
from sensorless.reproduce.signum import GAINS

CASES = [
    "fig4",
    "fig9",
    "fig11",
    "fig12",
    "fig13",
    "switching",
    "abstract",
    "timing",
    "layer",
    "printed",
]
DRAWN = CASES[:6]


def test_data(data: dict[str, Any]) -> None:
    """Every row has the paper and both of ours; every case says why."""
    assert list(data["cases"]) == CASES
    for case in data["cases"].values():
        assert len(case["why"]) > 40
        for row in case["rows"].values():
            assert set(row) == {"unit", "paper", "published", "corrected"}
            assert row["corrected"] is not None


def test_signum_and_sigmoid(data: dict[str, Any]) -> None:
    """In the order of Fig. 12: −24 degrees by the signum, −8 by the sigmoid, which is lag."""
    rows = data["cases"]["fig12"]["rows"]
    published = {name: row["published"] for name, row in rows.items()}
    assert -36.0 < published["largest error, signum"] < -12.0
    assert published["mean error, sigmoid"] == pytest.approx(-8.0, abs=0.5)
    assert published["chatter, signum, ±"] > 10.0 * published["chatter, sigmoid, ±"]
    assert abs(published["largest error, super-twisting"]) < 3.0


def test_the_gain_of_the_signum_decides(data: dict[str, Any]) -> None:
    """Near the EMF it is as good as the published sigmoid; −24° takes a multiple of it."""
    rows = data["cases"]["fig12"]["rows"]
    published = {name: row["published"] for name, row in rows.items()}
    best, sigmoid = "largest error, signum at its best gain", "largest error, sigmoid"
    assert abs(published[best]) < 1.1 * abs(published[sigmoid])
    assert published["its best gain"] < 2.0 < 4.0 < published["its gain, the nearest to −24°"]
    kept = [float(x) for x in published["lock kept on the signum alone, at"].split(", ")]
    assert published["its best gain"] in kept
    lost = sorted(set(GAINS) - set(kept))
    why = data["cases"]["fig12"]["why"]
    assert all(f"{x:g}" in why.split("alone, without load, ")[1] for x in lost)


def test_the_picture_reaches_what_the_table_says(done: list[Case]) -> None:
    """The curves of Fig. 12 hold the largest errors of its rows, and the sweep all of them."""
    case = next(c for c in done if c.name == "fig12")
    assert case.figure is not None
    left, right = case.figure.axes
    drawn = [np.asarray(line.get_ydata(), dtype=float) for line in left.get_lines()]
    told = {row.quantity: (row.published, row.corrected) for row in case.rows}
    wanted = [*told["largest error, signum"], *told["largest error, sigmoid"]]
    found = [float(y[np.argmax(np.abs(y))]) for y in (drawn[j] for j in (0, 2, 1, 3))]
    assert found == pytest.approx(wanted, abs=1e-3)
    assert all(np.shape(line.get_xdata()) == (len(GAINS),) for line in right.get_lines())


LINES = {
    "fig4": [{-8.0, 8.0}, set()],
    "fig9": [{0.5, 1.5, 2.5}, {-5.0, 5.0}, {0.0, 0.5, 1.0}],
    "fig11": [{-4.0, 4.0, 8.0}],
    "fig12": [{-24.0, -8.0}, {8.0, 24.0}],
    "fig13": [set(), {-5.0, -4.0, -3.0, 3.0, 4.0, 5.0}, {0.0, 0.5, 1.0}],
}


@pytest.mark.parametrize("name", LINES)
def test_the_paper_is_in_the_pictures(name: str, done: list[Case]) -> None:
    """A line for every value it gives, panel by panel."""
    case = next(c for c in done if c.name == name)
    assert case.figure is not None
    found = []
    for axes in case.figure.axes:
        (x, y) = ends(axes)
        found.append(
            {round(float(a if a == b else c), 6) for (a, b), (c, _) in zip(x, y, strict=True)}
        )
    assert found == LINES[name]


def ends(axes: Any) -> tuple[Any, Any]:
    """Abscissas and ordinates of the ends of the paper's lines."""
    lines = [s for c in axes.collections for s in getattr(c, "get_segments", list)()]
    points = np.array(lines).reshape(-1, 2, 2)
    return points[:, :, 0], points[:, :, 1]


def test_the_claim_about_the_torque_is_in_its_picture(done: list[Case]) -> None:
    """Each crossing has lines 45 % closer to each other than the hard switch's torque."""
    case = next(c for c in done if c.name == "switching")
    assert case.figure is not None
    told = {row.quantity: (row.published, row.corrected) for row in case.rows}
    for j, axes in enumerate(case.figure.axes):
        heights = ends(axes)[1][:, 0].reshape(-1, 2)
        hard = [told[f"exact sensors, hard switch, {way}"][j] for way in ("up", "down")]
        assert np.diff(heights)[:, 0] == pytest.approx(0.55 * np.array(hard), rel=1e-6)


def test_the_sigmoid_is_a_straight_line(data: dict[str, Any]) -> None:
    """Nothing slides in a drive on the sigmoid."""
    rows = data["cases"]["layer"]["rows"]
    assert rows["inside the layer, |a x/2| < 1"]["corrected"] == 100.0
    assert rows["tanh within 5 % of a straight line"]["corrected"] > 90.0
    assert np.tanh(STRAIGHT) / STRAIGHT == pytest.approx(0.95, abs=1e-5)


def test_published_is_published(data: dict[str, Any]) -> None:
    """The published column runs Eqs. 7, 9 and 26 and the plain sigmoid, not the corrected core."""
    design = data["designs"]["published"]
    assert design["hfi_scheme"] == "stationary" and not design["hfi_delay_cure"]
    assert not design["lag_cure"] and not design["L_q_table"] and design["cross"] == "none"
    seam = data["cases"]["printed"]["rows"]["largest angle error of Figs. 13/14"]
    assert seam["published"] > 90.0 > 10.0 > seam["corrected"]


def test_page(folder: Path) -> None:
    """Each case has its table, and each picture that is shown exists."""
    page = (folder / "paper.md").read_text(encoding="utf-8")
    assert page.count("| paper | as published | corrected |") == len(CASES)
    shown = [line.split("(")[-1].rstrip(")") for line in page.splitlines() if line.startswith("![")]
    assert shown == [f"{name}.png" for name in DRAWN]
    assert all((folder / name).read_bytes().startswith(b"\x89PNG") for name in shown)


def test_folder_that_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(UserError, match="output folder"):
        reproduce(tmp_path / "file" / "below")


def test_a_lost_drive_has_no_number() -> None:
    row = row_of("q", "1", "–", [float("nan"), 1.0])
    assert row == Row("q", "1", "–", row.published, 1.0)
    assert row.facts()["published"] is None


def test_every_setting_has_a_number(folder: Path) -> None:
    page = (folder / "paper.md").read_text(encoding="utf-8")
    assert "None" not in page
    assert "(corrected `auto = 14.93`)" in page
