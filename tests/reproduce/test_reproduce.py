"""The page of the reproduction: all of it there, three columns, nothing that is not a number."""

from pathlib import Path
from typing import Any

import pytest

from sensorless.errors import UserError
from sensorless.reproduce.case import Row, row_of
from sensorless.reproduce.reproduce import reproduce

CASES = [
    "fig4",
    "fig9",
    "fig11",
    "fig12",
    "fig13",
    "switching",
    "abstract",
    "timing",
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
    assert row.plain()["published"] is None
