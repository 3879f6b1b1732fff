"""``sensorless report``: one page that stands alone, and says what the evaluation said."""

import base64
import json
import zlib
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

pytest.importorskip("matplotlib")

from sensorless.cli.app import app
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machines_suite import on_machine
from sensorless.envs.scenarios.words import scenario_from
from sensorless.errors import UserError
from sensorless.evaluation.evaluate import evaluate
from sensorless.evaluation.machines import evaluate_machines
from sensorless.evaluation.results import Results
from sensorless.evaluation.results_tables import number
from sensorless.evaluation.trace import trace
from sensorless.machine.motor import Motor
from sensorless.policies.bench import Bench
from sensorless.policies.registry import make_policies
from sensorless.report.page import PARTS, UPLOT
from sensorless.report.report import Report
from sensorless.report.tables import COLUMNS
from sensorless.report.waves import LEVELS
from sensorless.units import RAD_S_TO_RPM

pytestmark = pytest.mark.usefixtures("short_suites")

MOTOR, DESIGN = Motor.load("paper"), DriveDesign()
SIZE = 6
OTHERS = ("eq25", "sliding_mode", "sensored")


class Page(HTMLParser):
    """What a page refers to, its tables as rows of texts, and the data of its script."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.rows: list[list[str]] = []
        self.text = ""
        self.data: dict[str, Any] = {}
        self.open: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("img", "meta", "input"):
            self.open.append(tag)
        self.links += [str(value) for name, value in attrs if name in ("src", "href")]
        if tag == "tr":
            self.rows.append([])
        if tag in ("td", "th"):
            self.rows[-1].append("")

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        """Lines and circles of pictures."""

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag, f"</{tag}> closes another one"

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "script":
            line = next(line for line in data.splitlines() if line.startswith("const data"))
            self.data = json.loads(line.removeprefix("const data = ").removesuffix(";"))
            return
        self.text += data
        if self.open and {"td", "th"} & set(self.open):
            self.rows[-1][-1] += data


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
    files = {path.name for path in (run / "report").iterdir()}
    assert files == {"index.html", "results-stress-1.json", "results-handoff.json"}
    assert (run / "report" / "index.html").stat().st_size < 3_000_000


def test_the_plotting_library_is_the_one_that_is_named() -> None:
    head = (PARTS / "uplot" / "uPlot.iife.min.js").read_text(encoding="utf-8")[:80]
    assert f"(v{UPLOT})" in head


@pytest.fixture(scope="module")
def judged(run: Path) -> Results:
    """What an evaluation of the same says."""
    design = DriveDesign(smo_pll_hz=21.0)
    return evaluate(MOTOR, design, "stress-1", 7, SIZE, make_policies([str(run), *OTHERS], MOTOR))


def test_the_page_says_what_the_evaluation_says(run: Path, page: Page, judged: Results) -> None:
    names = ["mine & yours", *OTHERS]
    table = [row for row in page.rows if len(row) == 1 + len(COLUMNS)][: 1 + len(names)]
    assert [row[0].split(" ")[0] for row in table] == ["policy", "mine", *names[1:]]
    for row, name in zip(table[1:], names, strict=True):
        policy = judged.policies[name]
        assert row[0].startswith(name) and judged.note(name) in row[0]
        for cell, (key, _, factor, digits) in zip(row[1:], COLUMNS, strict=True):
            assert cell.startswith(number(factor * policy[key], digits))
    written = json.loads((run / "report" / "results-stress-1.json").read_text(encoding="utf-8"))
    rate = judged.policies["eq25"]["lost_rate"]
    assert written["policies"]["eq25"]["lost_rate"] == pytest.approx(rate, rel=1e-8)
    assert "scenarios" not in written["policies"]["eq25"]


def test_where_the_papers_rule_stands_it_is_on_the_papers_observers_too(page: Page) -> None:
    """In rows or columns of every table, and in what the verdict stands on."""
    for suite in ("stress-1", "handoff"):
        for name in ("eq25", "sliding_mode"):
            assert f"Beside {name} on {suite}" in page.text
    heads = [row for row in page.rows if row[0] == "place"]
    assert len(heads) == 2
    for head in heads:
        assert [x.split()[-1] for x in head if x.startswith("lost")][1:] == ["eq25", "sliding_mode"]
    first = [row[0].split(" ")[0] for row in page.rows]
    assert first.count("eq25") == first.count("sliding_mode") == 4, "all and pairs of two suites"


def test_pairs_are_ours_minus_theirs(page: Page, judged: Results) -> None:
    row = next(row for row in page.rows if row[0] == "eq25" and len(row) == 2 + len(COLUMNS))
    deviation = judged.paired["eq25"]["torque_dev_rms"]
    assert row[1] == str(judged.paired["eq25"]["survived_both"])
    assert row[4].startswith(number(-100.0 * deviation, 2))
    rows = [judged.policies[name]["scenarios"] for name in ("mine & yours", "eq25")]
    both = ~np.array(rows[0]["lost"]) & ~np.array(rows[1]["lost"])
    ours, theirs = (np.mean(np.array(x["torque_dev_rms"])[both]) for x in rows)
    share = number(100.0 * (ours / theirs - 1.0), 0)
    assert row[4].endswith(f"{share} %")
    beside = next(row for row in page.rows if row[0] == "torque deviation")
    assert beside[1] == f"{number(100.0 * ours, 2)} %"
    assert beside[2] == f"{number(100.0 * theirs, 2)} %"


def test_waveforms_keep_every_peak(run: Path, page: Page) -> None:
    """Unpacked, a curve has the largest and the least value of the run."""
    word = next(c for c in page.data["cases"] if c.startswith("stress-1"))
    packed = page.data["cases"][word][1]
    design = DriveDesign(smo_pll_hz=21.0)
    eq25 = make_policies(["eq25"], MOTOR)["eq25"]
    native = trace(eq25, scenario_from(word, MOTOR), MOTOR, design, go_on=True)
    raw = zlib.decompress(base64.b64decode(packed["data"]))
    t = np.frombuffer(raw, "<f4", packed["n"])
    assert np.all(np.diff(t) > 0.0) and t[0] == np.float32(native["t"][0])
    curves = [curve for pane in packed["panes"] for curve in pane["curves"]]
    at = [curve["name"] for curve in curves].index("load")
    whole = np.frombuffer(raw, "<i2", packed["n"], 4 * packed["n"] + 2 * at * packed["n"])
    load = curves[at]["low"] + curves[at]["step"] * (whole + LEVELS // 2)
    for extreme in (np.min, np.max):
        assert extreme(load) == pytest.approx(extreme(native["tau_load"]), abs=curves[at]["step"])


def test_the_map_is_that_of_the_envelope(page: Page) -> None:
    found = page.data["maps"]["envelope eq25"]
    results = evaluate(
        MOTOR, DriveDesign(smo_pll_hz=21.0), "envelope", 7, 9, make_policies(["eq25"], MOTOR)
    )
    rows = results.policies["eq25"]["scenarios"]
    assert found["rows"] == found["columns"] == 3
    for j, (error, cause) in enumerate(
        zip(rows["angle_err_rms_deg"], rows["lost_cause"], strict=True)
    ):
        column, row = divmod(j, 3)  # speeds one after the other, loads within
        wanted = round(10 * error) if cause is None else -1 if "twin" in cause else -2
        assert found["values"][3 * row + column] == wanted


def test_commands_and_versions_are_there(run: Path, page: Page) -> None:
    assert "sensorless train --name <mine>" in page.text
    assert f"--suite handoff --seed 7 --size {SIZE} --details --set smo_pll_hz=21" in page.text
    assert "stress-1:7:" in page.text and "simulate --scenario SCENARIO" in page.text
    for text in (
        "torch, in training9.9",
        "numpy",
        "4000 decisions, seed 3",
        "45 nodes",
        "better than its start",
    ):
        assert text in page.text


def test_a_rule_without_a_table_has_a_report_too(tmp_path: Path) -> None:
    report = Report("hysteresis", Bench(MOTOR, DESIGN), others=["eq25"])
    written, said = report.write(tmp_path / "new", ["nominal"], 1, 3, 2, "sensorless report")
    page = Page(written.read_text(encoding="utf-8"))
    assert said.head in page.text
    assert not page.data["curves"]
    assert not any(key.startswith("table") for key in page.data["maps"])


@pytest.mark.parametrize(("run", "others"), [("hysteresis", ["eq25", "hfi"]), ("eq25", ["hfi"])])
def test_it_stands_beside_eq25_as_an_export_does(run: str, others: list[str]) -> None:
    """Or a rule that is worse than Eq. 25 is to be flashed where hfi is worse still."""
    assert Report(run, Bench(MOTOR, DESIGN), others=["hfi"]).others == others


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
    assert not list(tmp_path.iterdir())


def test_random_machines_have_a_report_too(tmp_path: Path) -> None:
    """Two machines of 16 scenarios, with the numbers of their evaluation and waveforms of each."""
    words = ["linear:100,700", "eq25"]
    bench = Bench(MOTOR, DESIGN)
    report = Report(words[0], bench, others=words[1:])
    page = Page(
        report.write(tmp_path, ["machines"], 3, 40, 2, "sensorless report")[0].read_text("utf-8")
    )
    results = evaluate_machines(DESIGN, 3, 2, lambda motor: make_policies(words, motor))
    assert "32 scenarios of machines (2 random ones)" in page.text
    assert "--suite machines --seed 3 --size 2" in page.text
    for j, machine in enumerate(results.policies["eq25"]["by_machine"]["machine"]):
        sides = [results.policies[word]["by_machine"] for word in words]
        cells = [machine, str(sides[0]["feasible"][j]), *(str(s["lost"][j]) for s in sides)]
        assert [*cells, *(number(100.0 * s["torque_dev_rms"][j], 2) for s in sides)] in page.rows
    word = results.policies[words[0]]["worst"][0]["scenario"]
    motor, plain = on_machine(word)
    own = make_policies(words[:1], motor)[words[0]]
    run = trace(own, scenario_from(plain, motor), motor, DESIGN, go_on=True)
    curves = page.data["cases"][word][0]["panes"][0]["curves"]
    (speed,) = (curve for curve in curves if curve["name"] == "sensorless")
    top = float(np.max(run["omega_m"])) * RAD_S_TO_RPM
    assert speed["low"] + LEVELS * speed["step"] == pytest.approx(top, rel=1e-9)


def test_a_report_needs_no_library_that_is_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sensorless.report.report.find_spec", lambda name: None)
    others = Report("eq25", Bench(MOTOR, DESIGN)).others
    assert "linear-tuned" in others and not [name for name in others if "fuzzy" in name]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("index.html", "mine"),
        ("results-stress-1.json", "mine"),
        ("results-stress-1.json", '{"policies": []}'),
        ("results-stress-1.json", '{"policies": {"eq25": {"scenarios": {}}}}'),
    ],
)
def test_a_file_of_somebody_else_is_kept(tmp_path: Path, name: str, text: str) -> None:
    """Results with single scenarios are those of ``evaluate``."""
    (tmp_path / name).write_text(text)
    done = CliRunner().invoke(
        app, ["report", "eq25", "--suite", "stress-1", "--size", "4", "--out", str(tmp_path)]
    )
    assert isinstance(done.exception, UserError) and name in str(done.exception)
    assert (tmp_path / name).read_text() == text
    assert [file.name for file in tmp_path.iterdir()] == [name]


def test_rules_tuned_for_another_motor_are_left_out() -> None:
    """They run on the paper's observers too, whose part would count as the policy's."""
    others = Report("eq25", Bench(Motor.load("ipmsm_2200w"), DESIGN)).others
    assert others == ["sliding_mode", "oracle", "sensored"]
