"""The checks of the mutation campaign pass on the core as it is, and notice mistakes."""

import shutil
from pathlib import Path

import pytest

from sensorless.core.api import lib
from tests.mutants.build import DRIVE, compile_checks, run_checks, write_params
from tests.mutants.mutate import Mutant, all_mutants, mutants_of
from tests.mutants.run import summary

MISTAKES = {
    "ks_slew lets -0.1 through": (
        "blend.h",
        "return y >= 0.0f ? y : 0.0f;",
        "return y >= -1.0f ? y : 0.0f;",
        "k_s below 0",
    ),
    "a filter 10 % off": (
        "drive_observe.h",
        "y->emf += a * (",
        "y->emf += 1.1f * a * (",
        "filter: EMF",
    ),
    "a term of the flux error 10 % off": (
        "flux_model.h",
        "(e.d * y->aux.q - e.q * y->aux.d)",
        "(e.d * y->aux.q - 1.1f * e.q * y->aux.d)",
        "flux's error",
    ),
    "a factor of the start 10 % off": (
        "start_sequence.h",
        "0.5f * p->k_hold",
        "0.55f * p->k_hold",
        "hold",
    ),
}
"""Mistakes that tests once missed: file, text, text with the mistake, check that notices."""


def test_mistakes_that_were_missed_are_noticed(tmp_path: Path) -> None:
    """The core as it is passes every check; with all mistakes at once, the check of each fails."""
    write_params(tmp_path)
    program = compile_checks(DRIVE, tmp_path)
    assert program is not None and run_checks(program)[0] == []
    wrong = tmp_path / "drive"
    shutil.copytree(DRIVE, wrong)
    for file, text, mistake, _ in MISTAKES.values():
        whole = (wrong / file).read_text(encoding="utf-8")
        assert whole.count(text) >= 1
        (wrong / file).write_text(whole.replace(text, mistake), encoding="utf-8")
    program = compile_checks(wrong, tmp_path)
    assert program is not None
    assert {check for *_, check in MISTAKES.values()} <= set(run_checks(program)[0])


def test_mutants_change_code_and_nothing_else(tmp_path: Path) -> None:
    code = "/* a + b */\n#include <a.h>\nfloat f(float x) { return x + 2.0f < 1.0f ? x : -x; }\n"
    (tmp_path / "a.h").write_text(code)
    found = {m.rule: m.after for m in mutants_of(tmp_path / "a.h")}
    assert found["plus to minus"] == "float f(float x) { return x - 2.0f < 1.0f ? x : -x; }"
    assert found["dropped term"] == "float f(float x) { return x + 0 * 2.0f < 1.0f ? x : -x; }"
    assert found["choice turned"] == "float f(float x) { return x + 2.0f < 1.0f ? -x : x; }"
    assert found["less or equal"] == "float f(float x) { return x + 2.0f <= 1.0f ? x : -x; }"
    assert all(m.line == 3 for m in mutants_of(tmp_path / "a.h"))
    assert len(all_mutants(DRIVE)) > 1500


def test_the_record_counts() -> None:
    a, b = (Mutant("a.h", 1, "rule", "x", after, "") for after in ("y", "z"))
    found = [(a, "check", ["PLL"]), (b, "lives", []), (a, "sum", []), (a, "invalid", [])]
    record = summary(found, {"z": "same: no effect"})
    assert record["viable"] == 3 and record["dead_pct"] == 100.0 and record["by_checks_pct"] == 50.0
    assert summary(found, {})["dead_pct"] == pytest.approx(66.67)
    assert record["survivors"][0]["why"] == "same: no effect"
    assert lib.FAULT_ALL >= lib.FAULT_STATE
