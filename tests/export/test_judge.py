"""An export tells what its schedule is worth, and refuses one that is unfit."""

import re
from dataclasses import replace
from math import nan
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.machine_family import member
from sensorless.errors import UserError
from sensorless.evaluation import machine_check
from sensorless.evaluation.compare import Comparison
from sensorless.evaluation.machine_check import SUITES, Check, QuickRun
from sensorless.evaluation.objective import Cost
from sensorless.export import judge as module
from sensorless.export.export import Exported
from sensorless.export.judge import Judged
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.policy import Policy
from sensorless.report.motor_check import check
from sensorless.suitability.examine import Examination
from sensorless.suitability.finding import LIMIT, NO, Finding
from sensorless.table.ks_table import KsTable
from tests.helpers.command import run

PAPER = Motor.load("paper")
LEVEL = Comparison(
    "Eq. 25", 400, 400, Cost(0.0, 0.03, 0.01), Cost(0.0, 0.03, 0.01), 0.0, (-1e-3, 1e-3), False
)
WORSE = replace(LEVEL, change=1e-3, interval=(1e-4, 2e-3))
BETTER = replace(LEVEL, change=-1e-3, interval=(-2e-3, -1e-4))


def suits(weight: str) -> Check:
    """A check of a machine with one finding."""
    return Check(Examination(PAPER, (Finding(weight, "psi_f", "psi_f = 8"),)), ())


@pytest.mark.parametrize(
    ("judged", "objection"),
    [
        (Judged(10, 200, 200, LEVEL), ""),
        (Judged(0, 200, 200, BETTER), ""),
        (Judged(11, 200, 200, BETTER), "it loses 11 of 200 scenarios of nominal, more than 5 %"),
        (Judged(0, 200, 200, WORSE), "worse than Eq. 25"),
        (Judged(3, 42, 200, BETTER), "it loses 3 of 42 feasible scenarios (200 drawn) of nominal"),
        (Judged(0, 0, 200, LEVEL), "no scenario of nominal is feasible"),
        (Judged(0, 99, 200, LEVEL), "even with an encoder, the drive fails 101 of 200"),
        (
            Judged(0, 200, 200, LEVEL, suits(NO)),
            "its machine does not suit, because psi_f = 8",
        ),
        (
            Judged(0, 200, 200, LEVEL, suits(NO), suits=True),
            "it does not suit its machine, as Eq. 25 does, because psi_f = 8",
        ),
        (Judged(0, 200, 200, LEVEL, suits(LIMIT)), ""),
    ],
)
def test_what_is_refused(judged: Judged, objection: str) -> None:
    assert judged.objection.startswith(objection) and bool(judged.objection) == bool(objection)


@pytest.mark.usefixtures("without_selftest")
def test_the_unfit_is_refused_and_written_by_force(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(module, "judge_export", lambda *_: Judged(11, 200, 200, WORSE))
    words = ["export", "eq25", "--out", "out", "--no-fit"]
    done = run(*words, cwd=tmp_path)
    assert done.returncode == 2 and done.stderr.count("\n") == 1
    assert "loses 11 of 200" in done.stderr and "--force" in done.stderr
    assert not list(tmp_path.iterdir()), "nothing half-written"
    done = run(*words, "--force", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    opening = (tmp_path / "out/README.md").read_text().splitlines()[2]
    assert opening.startswith("**Verdict:** not fit to run a motor: it loses 11 of 200")
    assert done.stdout.splitlines()[-1].startswith("verdict: not fit")


@pytest.mark.usefixtures("without_selftest")
def test_the_verdict_of_a_real_one(tmp_path: Path) -> None:
    """Eq. 25 is as good as Eq. 25, and loses nothing."""
    done = run("export", "eq25", "--out", "out", "--no-fit", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    last = done.stdout.splitlines()[-1].removeprefix("verdict: ")
    assert last.startswith("the same as Eq. 25") and "lost 0 of 8 scenarios of nominal" in last
    assert f"**Verdict:** {last}." in (tmp_path / "out/README.md").read_text()
    told = ", ".join(f"{suite} 0 %" for suite in SUITES)
    assert last.endswith(f"motor check with it: yes, lost {told}")
    known = KsTable.load(tmp_path / "out/ks_table.json").provenance["judged"]
    assert known["nominal"]["lost"] == 0 and known["eq25"]["same"]
    assert known["motor_check"]["suitable"] == "yes"
    assert len(known["motor_check"]["runs"]) == len(SUITES)


def test_a_machine_that_the_simulation_of_its_check_refuses(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Its numbers pass, and Eq. 25 is no worse than Eq. 25."""
    monkeypatch.setattr(module, "CHECKED", 20)
    monkeypatch.setattr(machine_check, "SUITES", ("stress", "handoff", "hold"))
    weak = member(1000502, 54)
    judged = module.judge_export(make_policy("eq25", weak), weak, DriveDesign())
    found = check(weak, DriveDesign(), 20).examination.verdict
    assert found.word == "no"
    assert judged.unsuited == tuple(x.replace("Eq. 25", "the schedule") for x in found.because)
    with pytest.raises(UserError, match=r"loses \d+% .* of stress.*--force.*motor check"):
        module.require_fit(judged, "eq25")
    told = module.verdict(judged)
    assert told.startswith("not fit to run a motor: its machine does not suit, because the drive")
    assert re.search(r"check with it: no, lost stress \d\d %, handoff \d+ %, hold", told)


def test_a_schedule_that_loses_what_eq25_keeps(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its machine is not to blame."""
    monkeypatch.setattr(module, "CHECKED", 20)
    monkeypatch.setattr(machine_check, "SUITES", ("stress", "handoff", "hold"))
    judged = module.judge_export(make_policy("constant:0", PAPER), PAPER, DriveDesign())
    assert judged.suits and judged.objection.startswith(
        "it does not suit its machine, as Eq. 25 does"
    )
    with pytest.raises(UserError, match="export eq25, or train"):
        module.require_fit(judged, "constant:0")


def test_what_is_worse_than_eq25_is_told_to_be_replaced_by_it() -> None:
    with pytest.raises(UserError, match=r"worse than Eq\. 25.*: export eq25, or train"):
        module.require_fit(Judged(0, 200, 200, WORSE), "linear.json")


def test_a_suite_that_no_drive_can_run_is_told() -> None:
    runs = (QuickRun("unload", 9, 0.25, 0.0, 0.1, 0.1), QuickRun("stress", 9, nan, nan, 1.0, nan))
    judged = Judged(0, 200, 200, LEVEL, replace(suits(LIMIT), runs=runs))
    told = "with limits, lost unload 25 %, stress not feasible, because psi_f = 8"
    assert module.verdict(judged).endswith(told)
    assert judged.facts()["motor_check"]["runs"][1]["lost"] is None
    slips = replace(suits(LIMIT), runs=(replace(runs[0], slipped=0.005),))
    told = "lost unload 25 %, slips and comes back in 0.5 % of unload, because"
    assert told in module.verdict(replace(judged, machine=slips))


def test_what_nobody_judged_says_so(exported: Exported) -> None:
    assert "**Verdict:** not judged" in (exported.folder / "README.md").read_text()


@pytest.mark.parametrize(
    ("machine", "under_eq25", "suited"),
    [(NO, LIMIT, True), (NO, NO, False), (LIMIT, NO, False), (LIMIT, LIMIT, False)],
)
def test_what_is_judged(
    machine: str, under_eq25: str, suited: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three lost of seven that are feasible of nine; its machine beside that under Eq. 25."""
    lost, feasible = np.arange(9) < 3, np.arange(9) < 7
    policy = make_policy("constant:0", PAPER)

    def checked(motor: Motor, design: DriveDesign, run: Policy, under: str, size: int) -> Check:
        assert (under == "Eq. 25") == (run is not policy)
        return suits(under_eq25 if under == "Eq. 25" else machine)

    monkeypatch.setattr(
        module, "outcomes", lambda *_: SimpleNamespace(lost=lost, feasible=feasible)
    )
    monkeypatch.setattr(module, "compare", lambda *_: LEVEL)
    monkeypatch.setattr(module, "check", checked)
    judged = module.judge_export(policy, PAPER, DriveDesign())
    assert (judged.lost, judged.nominal, judged.drawn, judged.suits) == (3, 7, 9, suited)
    assert judged.facts()["nominal"] == {"seed": 1, "scenarios": 7, "lost": 3}


def test_who_is_to_be_mended() -> None:
    """The motor file where the machine is to blame, the schedule where Eq. 25 does with it."""
    blamed = Judged(0, 200, 200, LEVEL, suits(NO))
    with pytest.raises(UserError, match=r"correct the motor file .*--force"):
        module.require_fit(blamed, "x")
    with pytest.raises(UserError, match="export eq25, or train or tune"):
        module.require_fit(replace(blamed, suits=True), "x")
    with pytest.raises(UserError, match=": train or tune one"):
        module.require_fit(Judged(11, 200, 200, LEVEL), "x")
    assert not Judged(0, 100, 200, LEVEL).objection, "half of the scenarios are enough"
    module.require_fit(Judged(10, 200, 200, LEVEL), "x")
