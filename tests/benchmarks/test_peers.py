"""The comparison with other simulators, as far as it needs neither network nor the peers."""

import subprocess
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from sensorless.errors import UserError
from tests.helpers.script import script


@pytest.fixture(scope="module")
def peers() -> ModuleType:
    return script("benchmarks/peers.py")


def found() -> dict[str, Any]:
    """Rates with easy ratios."""
    rate = {"per_s": 2.0, "per_cpu_s": 4.0}
    gem = {"environment, euler": rate, "environment, scipy": rate}
    others = {"flux observer, averaged": rate, "injection, PWM and dead time": rate}
    names = ("machine alone", "drive and its sensored twin", "drive")
    ours = {name: {"per_s": 1.0, "per_cpu_s": 40.0} for name in names}
    told = {"versions": {"python": "3.12.0"}}
    return {
        "cores": 2,
        "ours": {"rates": ours, **told},
        "gem": {"rates": gem, **told},
        "motulator": {"rates": others, **told},
        "all cores": dict.fromkeys(names[1:], 6000.0),
    }


def test_ratios_are_core_to_core_and_machine_to_process(peers: ModuleType) -> None:
    rows = peers.ratios(found())
    assert [row["core_to_core"] for row in rows] == [10.0] * len(peers.COMPARED)
    for row in rows:
        wanted = None if row["ours"] == "machine alone" else 1500.0
        assert row["machine_to_process"] == wanted


def test_the_report_names_every_rate_and_what_is_wanted(peers: ModuleType) -> None:
    data = found()
    data["ratios"] = peers.ratios(data)
    text = peers.report(data)
    for who in ("ours", "gem", "motulator"):
        assert all(name in text for name in data[who]["rates"])
    assert "2 cores to one process 1,500 (wanted: 5,000)" in text


def test_the_last_line_is_the_result(peers: ModuleType) -> None:
    assert peers.parse("gem", 0, 'a warning\n{"rates": {}}\n', "") == {"rates": {}}


@pytest.mark.parametrize(
    ("status", "out", "err", "said"),
    [(1, "", "Traceback\nKeyError: 'x'\n", "KeyError: 'x'"), (0, "", "", "no output")],
)
def test_a_runner_that_fails_is_one_line(
    peers: ModuleType, status: int, out: str, err: str, said: str
) -> None:
    with pytest.raises(UserError, match=r"^gem: ") as caught:
        peers.parse("gem", status, out, err)
    assert said in str(caught.value) and "\n" not in str(caught.value)


def test_a_python_is_found_or_named(peers: ModuleType, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peers, "pythons", lambda: ["/no/such/python", sys.executable])
    assert peers.python_for((3, 10)) == sys.executable
    with pytest.raises(UserError, match=r"none of 4\.0 or newer.*PEERS_PYTHON"):
        peers.python_for((4, 0))


def test_without_the_index_it_says_so(
    peers: ModuleType, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(peers, "ROOT", tmp_path)
    monkeypatch.setattr(peers, "FOLDER", tmp_path / "peers")
    monkeypatch.setattr(peers, "python_for", lambda least: sys.executable)

    def offline(words: list[str], **_: Any) -> "subprocess.CompletedProcess[str]":
        failed = int("pip" in words)
        return subprocess.CompletedProcess(words, failed, "", "ERROR: No matching distribution\n")

    monkeypatch.setattr("subprocess.run", offline)
    with pytest.raises(UserError, match=r"gym-electric-motor==.*No matching distribution"):
        peers.install("gem")


def test_every_comparison_has_its_meaning_written_down(peers: ModuleType) -> None:
    for _, variant, peer, _, _ in peers.COMPARED:
        assert {variant, peer} <= set(peers.WHAT)
