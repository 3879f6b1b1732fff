"""``sensorless evaluate`` as a user meets it; more of it in ``test_cli.py``."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.errors import UserError
from sensorless.policies.registry import known

RUN = CliRunner()


def test_the_list_has_one_line_for_every_policy() -> None:
    done = RUN.invoke(app, ["evaluate", "--list"])
    assert done.exit_code == 0
    said = re.sub(r"\n +", "  ", done.stdout).splitlines()  # a long name has a line of its own
    assert [line.split("  ")[0] for line in said] == list(known())
    assert [" ".join(line.split("  ")[1:]).strip() for line in said] == list(known().values())
    assert max(map(len, done.stdout.splitlines())) < 120


def test_the_list_is_there_for_programs_too() -> None:
    for words in (["--list", "--json"], ["--json", "--list"]):
        assert json.loads(RUN.invoke(app, ["evaluate", *words]).stdout) == known()


def test_details_and_a_file_without_scenarios(tmp_path: Path) -> None:
    out = tmp_path / "r.json"
    words = ["evaluate", "--policy", "eq25", "--policy", "sensored", "--size", "3", "--details"]
    done = RUN.invoke(app, [*words, "--no-scenarios", "--out", str(out)])
    assert done.exit_code == 0, done.output
    for heading in (
        "difference to eq25",
        "forward regenerating",
        "worst cases",
        "(told truth",
    ):
        assert heading in done.stdout
    assert done.stdout.count("window:") == 2 * 2, "means and pairs"
    data = json.loads(out.read_text(encoding="utf-8"))
    assert "scenarios" not in data["policies"]["eq25"]
    assert data["policies"]["eq25"]["worst"][0]["scenario"].startswith("stress-1:1:")


def test_a_worst_case_is_replayed_on_the_same_drive() -> None:
    """The words under the table, with a policy and a scenario of it."""
    words = ["--motor", "ipmsm_2200w", "--set", "estimator=smo"]
    done = RUN.invoke(app, ["evaluate", *words, "--policy", "eq25", "--size", "3"])
    told = " ".join(done.stdout.split())
    assert f"sensorless simulate {' '.join(words)} --policy POLICY --scenario SCENARIO" in told
    plain = RUN.invoke(app, ["evaluate", "--policy", "eq25", "--size", "3"]).stdout
    assert "sensorless simulate --policy POLICY" in " ".join(plain.split())


def test_random_machines_have_a_table_of_their_own() -> None:
    words = ["evaluate", "--policy", "eq25", "--policy", "reference", "--suite", "machines"]
    done = RUN.invoke(app, [*words, "--size", "1"])
    assert done.exit_code == 0, done.output
    assert "machine by machine" in done.stdout and "0 of 1" in done.stdout
    refused = RUN.invoke(app, [*words, "--motor", "paper"])
    assert isinstance(refused.exception, UserError) and "leave out --motor" in str(
        refused.exception
    )


def test_the_envelope_is_drawn_as_it_was_judged(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    from PIL import Image

    words = ["evaluate", "--suite", "envelope", "--size", "9"]
    for name in ("smo", "sensored"):
        plot = tmp_path / f"{name}.png"
        done = RUN.invoke(app, [*words, "--policy", name, "--plot", str(plot)])
        assert done.exit_code == 0, done.output
    dark = {
        name: np.mean(np.asarray(Image.open(tmp_path / f"{name}.png").convert("L")) < 40)
        for name in ("smo", "sensored")
    }
    assert dark["smo"] > dark["sensored"] + 0.02, "the observer alone cannot stand still"


def test_other_suites_have_no_picture(tmp_path: Path) -> None:
    plot = tmp_path / "x.png"
    done = RUN.invoke(app, ["evaluate", "--policy", "eq25", "--plot", str(plot)])
    assert isinstance(done.exception, UserError) and "envelope" in str(done.exception)
    assert not plot.exists()
