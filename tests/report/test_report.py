"""``sensorless report``: one page that stands alone, and says what the evaluation said."""

import base64
import json
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

pytest.importorskip("matplotlib")

from sensorless.baselines.linear import linear_table
from sensorless.cli.app import app
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import evaluate
from sensorless.evaluation.results_tables import number
from sensorless.machine.motor import Motor
from sensorless.policies.bench import Bench
from sensorless.policies.registry import make_policies
from sensorless.report.cases import CROSSED, cases
from sensorless.report.page import COLUMNS, RATE_COLUMNS
from sensorless.report.report import Report
from sensorless.table.ks_table import Axis, KsTable

MOTOR, DESIGN = Motor.load("paper"), DriveDesign()
SIZE = 6
OTHERS = ("eq25", "flux_observer", "sensored")
CURVE = "steps,seconds,lost_rate,torque_dev,torque_ripple,objective,best\n" + "".join(
    f"{1000 * j},{20.0 * j},{0.04 - 0.01 * j},0.06,0.017,{0.5 - 0.1 * j},1\n" for j in range(4)
)


class Page(HTMLParser):
    """What a page refers to, its pictures, and its tables as rows of texts."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.pictures: list[bytes] = []
        self.rows: list[list[str]] = []
        self.text = ""
        self.open: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("img", "meta"):
            self.open.append(tag)
        for name, value in attrs:
            if name == "src" and value and value.startswith("data:image/png;base64,"):
                self.pictures.append(base64.b64decode(value.split(",", 1)[1], validate=True))
            elif name in ("src", "href"):
                self.links.append(str(value))
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag, f"</{tag}> closes another one"

    def handle_data(self, data: str) -> None:
        self.text += data
        if self.open and {"td", "th"} & set(self.open):
            self.rows[-1][-1] += data


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
            "motor_digest": MOTOR.digest,
            "command": "sensorless train --name <mine>",
            "steps": 4000,
            "seed": 3,
            "versions": {"torch": "9.9"},
        },
    )
    (folder / "progress.csv").write_text(CURVE)
    (folder / "verdict.json").write_text('{"verdict": "better than its start"}')
    return folder


@pytest.fixture(scope="module")
def page(run: Path) -> Page:
    words = ["report", str(run), "--size", str(SIZE), "--grid", "3"]
    for name in OTHERS:
        words += ["--policy", name]
    done = CliRunner().invoke(app, [*words, "--set", "smo_pll_hz=21"])
    assert done.exit_code == 0, done.output
    return Page((run / "report" / "index.html").read_text(encoding="utf-8"))


def test_the_page_stands_alone(run: Path, page: Page) -> None:
    assert not page.open, "every tag is closed"
    assert page.links and all(link.startswith("#") for link in page.links)
    files = {path.name: path.read_bytes() for path in (run / "report").glob("*.png")}
    assert sorted(page.pictures) == sorted(files.values())
    assert {"envelope.png", "schedule.png", "learning.png", "stress-1-places.png"} <= set(files)
    assert sum(name.startswith("handoff-") for name in files) >= 3
    assert 4 * sum(map(len, files.values())) < 1_500_000, "full pictures: 9 times the dots"
    assert not list((run / "report").glob(".*")), "nothing half-written is left"


def test_the_page_says_what_the_evaluation_says(run: Path, page: Page) -> None:
    design = DriveDesign(smo_pll_hz=21.0)
    results = evaluate(
        MOTOR, design, "stress-1", 7, SIZE, make_policies([str(run), *OTHERS], MOTOR)
    )
    rows = {row[0]: row for row in page.rows if len(row) == 1 + len(RATE_COLUMNS) + len(COLUMNS)}
    names = ["mine & yours (smo)", "eq25", "flux_observer (flux)", "sensored (bound)"]
    assert set(rows) >= set(names)
    table = page.rows[: len(results.policies) + 1]
    assert [row[0] for row in table] == ["policy", *names]
    for row, policy in zip(table[1:], results.policies.values(), strict=True):
        for cell, (key, _, factor, digits) in zip(row[1:], (*RATE_COLUMNS, *COLUMNS), strict=True):
            assert cell.startswith(number(factor * policy[key], digits))
    written = json.loads((run / "report" / "results-stress-1.json").read_text(encoding="utf-8"))
    rate = results.policies["eq25"]["lost_rate"]
    assert written["policies"]["eq25"]["lost_rate"] == pytest.approx(rate, rel=1e-8)
    assert "scenarios" not in written["policies"]["eq25"]


def test_pairs_are_ours_minus_theirs(run: Path, page: Page) -> None:
    design = DriveDesign(smo_pll_hz=21.0)
    results = evaluate(MOTOR, design, "stress-1", 7, SIZE, make_policies([str(run), "eq25"], MOTOR))
    row = next(
        row
        for row in page.rows
        if row[0] == "eq25" and len(row) == 2 + len(RATE_COLUMNS) + len(COLUMNS)
    )
    deviation = results.paired["eq25"]["torque_dev_rms"]
    assert row[1] == str(results.paired["eq25"]["survived_both"])
    assert row[4].startswith(number(-100.0 * deviation, 2))
    rows = [results.policies[name]["scenarios"] for name in results.policies]
    both = ~np.array(rows[0]["lost"]) & ~np.array(rows[1]["lost"])
    ours, theirs = (np.mean(np.array(x["torque_dev_rms"])[both]) for x in rows)
    share = number(100.0 * (ours / theirs - 1.0), 0)
    assert row[4].endswith(f"{share} %")


def test_commands_and_versions_are_there(run: Path, page: Page) -> None:
    assert "sensorless train --name <mine>" in page.text
    assert f"--suite handoff --seed 7 --size {SIZE} --details --set smo_pll_hz=21" in page.text
    assert "sensorless simulate --scenario stress-1:7:" in page.text
    for text in (
        "torch, in training9.9",
        "numpy",
        "4000 decisions, seed 3",
        "45 nodes",
        "better than its start",
    ):
        assert text in page.text


def test_a_rule_without_a_table_has_a_report_too(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sensorless.report.report.png", lambda figure: b"a picture")
    report = Report("hysteresis", Bench(MOTOR, DESIGN), others=["eq25"])
    written = report.write(tmp_path / "new", ["nominal"], 1, 3, 2, "sensorless report hysteresis")
    files = {path.name for path in (tmp_path / "new").iterdir()}
    assert written.name in files and "schedule.png" not in files and "learning.png" not in files


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["report", "eq25"], "--out"),
        (["report", "nobody", "--out", "x"], "nobody"),
        (["report", "eq25", "--out", "x", "--suite", "easy", "--grid", "2"], "easy"),
        (["report", "eq25", "--out", "/proc/nowhere"], "/proc"),
    ],
)
def test_mistakes(words: list[str], said: str, tmp_path: Path, monkeypatch: Any) -> None:
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, words)
    assert isinstance(done.exception, UserError)
    assert said in str(done.exception)
    assert not list(tmp_path.rglob("*.*"))


def test_cases_are_a_typical_and_the_worst_hand_over() -> None:
    results = evaluate(
        MOTOR, DESIGN, "handoff", 7, 12, make_policies(["linear:100,700", "eq25"], MOTOR)
    )
    found = {case.key: case for case in cases(results, "linear:100,700", "eq25")}
    rows = results.policies["linear:100,700"]["scenarios"]
    crossed = [
        i
        for i in range(12)
        if not rows["lost"][i] and rows["k_s_activity"][i] * rows["time_s"][i] >= CROSSED
    ]
    assert len(crossed) > 2
    middle = sorted(crossed, key=lambda i: rows["torque_p2p_handover"][i])[(len(crossed) - 1) // 2]
    worst = max(crossed, key=lambda i: rows["torque_dev_rms"][i])
    assert found["handoff-typical"].scenario == f"handoff:7:{middle}"
    assert found["handoff-worst"].scenario == f"handoff:7:{worst}"
    assert len({case.scenario for case in found.values()}) == len(found)


def test_where_the_weight_never_moves_there_is_no_hand_over() -> None:
    results = evaluate(MOTOR, DESIGN, "handoff", 7, 3, make_policies(["hfi", "eq25"], MOTOR))
    keys = [case.key for case in cases(results, "hfi", "eq25")]
    assert "handoff-typical" not in keys and "handoff-worst-hfi" in keys


def test_tables_of_one_axis_are_drawn() -> None:
    from sensorless.plots.schedule import schedule_maps

    table = linear_table(0.2, 0.3)
    assert len(schedule_maps("eq25", table, table, MOTOR).axes) == 3
