"""What a processor in the loop counts, against numbers by hand; no target is needed."""

import subprocess
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from sensorless.core.api import SIGNAL_NAMES, Array, lib
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.machine.motor import Motor
from sensorless.pil import tools
from sensorless.pil.device import (
    ANSWERS,
    DRIVES,
    STEP_ANSWER,
    Operation,
    lookup_items,
    start_items,
)
from sensorless.pil.lockstep import WORDS, canonical, lockstep
from sensorless.pil.pil import instructions, passed
from sensorless.pil.report import table as report_table
from sensorless.pil.scenarios import PLANS, pil_scenarios
from sensorless.table.ks_table import Axis, KsTable
from tests.helpers.scenarios import cut

PAPER = Motor.load("paper")


def test_instructions_are_ticks_over_those_of_a_thousand_and_their_call() -> None:
    """20 ticks of the measurement itself; 1002 instructions take 2 ticks each."""
    info = np.zeros((), dtype=ANSWERS[Operation.INFO])
    info["ticks_0"], info["ticks_1000"] = 20, 20 + 2 * 1002
    assert instructions(np.array([20, 22, 421], np.uint32), info).tolist() == [0.0, 1.0, 200.0]


@pytest.mark.parametrize(
    "wrong", ["", "mismatches", "lookup_mismatches", "fused_instructions", "a test"]
)
def test_one_thing_wrong_is_enough(wrong: str) -> None:
    report: dict[str, Any] = dict.fromkeys(
        ("mismatches", "lookup_mismatches", "fused_instructions"), 0
    )
    report["target_tests"] = {"one": 0, "another": int(wrong == "a test")}
    if wrong in report:
        report[wrong] = 1
    assert passed(report) == (not wrong)


def test_the_scenarios_by_hand() -> None:
    names, s = pil_scenarios(PAPER, 5, 11)
    rated = PAPER.omega_m_rated
    assert names == (*PLANS, "stress-1:5:0", "stress-1:5:1", "stress-1:5:2") and len(s) == 11
    row = names.index("load steps")
    assert s.t[row, :4].tolist() == [0.0, 0.5, 1.0, 1.5]
    assert s.omega[row] == pytest.approx(np.full(s.omega.shape[1], 0.25 * rated))
    assert s.tau[row, :4] == pytest.approx(PAPER.tau_rated * np.array([0.0, 0.6, -0.4, 0.3]))
    assert s.tau[row, 4:] == pytest.approx(0.3 * PAPER.tau_rated), "the last one stays"
    assert s.omega_rate[:8] == pytest.approx(np.full(s.omega_rate[:8].shape, rated))
    assert [names[j] for j in np.flatnonzero(s.seek[:8])] == ["unknown angle", "spinning shaft"]
    assert s.theta_err_0[:8].tolist() == [0.0] * 5 + [2.5, 0.0, 0.0]
    assert s.omega_0[:8] == pytest.approx([0.0] * 6 + [-0.6 * rated, 0.0])
    assert s.offset[7] == pytest.approx([1.5 * PAPER.i_rated, 0.0])
    assert (s.L_q_hat == 1.0).all() and (s.cross_hat == 1.0).all(), "the export's numbers"


def test_starts_and_lookups() -> None:
    item = start_items(*(np.array([x]) for x in (0.1, 2.0, 0.3, 1.0)))[0]
    assert [float(item[x]) for x in ("theta", "omega", "k_s", "seek")] == pytest.approx(
        [0.1, 2.0, 0.3, 1.0]
    )
    x = lookup_items(np.random.default_rng(0), (Axis("speed", 0.1, 0.5, 3),))
    speed = x[:, SIGNAL_NAMES.index("speed")]
    usual = speed[np.isfinite(speed) & (np.abs(speed) < 1e30) & (np.abs(speed) > 1e-30)]
    assert -0.02 <= usual.min() < 0.0 and 0.6 < usual.max() <= 0.62
    for end in (0.1, 0.5):
        assert 60 < np.sum(speed == np.float32(end)) < 150, "a tenth of them, at either end"
    assert 15 < np.sum(~np.isfinite(speed)) < 40, "a twentieth is odd, of that three in seven"


def test_every_nan_is_the_same_word() -> None:
    words = np.array([0x7FC00001, 0xFF800001, 0xFF800000, 5], dtype=np.uint32)
    assert canonical(words).tolist() == [0x7FC00000, 0x7FC00000, 0xFF800000, 5]


class Host:
    """In place of a device: what the host has, but for one word of a drive in each of ``wrong``."""

    def __init__(self, sims: Array, wrong: dict[int, int]) -> None:
        self.sims, self.wrong, self.k = sims, wrong, 0
        self.weights: list[Array] = []

    def answer(self) -> Array:
        out = np.zeros(len(self.sims), dtype=STEP_ANSWER)
        out["x"], out["u"] = self.sims["drive"]["x"], self.sims["drive"]["u"]
        return out

    def ask(self, operation: Operation, items: Array) -> Array:
        assert operation == Operation.START and not items["seek"].any()
        return self.answer()

    def send(self, operation: Operation, inputs: Array) -> None:
        assert operation == Operation.STEP and len(inputs) == len(self.sims)

    def receive(self, operation: Operation, n: int) -> Array:
        out = self.answer()
        out["schedule"]["k_s_ref"], out["schedule"]["check"] = 0.25, lib.KS_GOOD
        out["schedule"]["wait"] = 4 - self.k % 5
        out["ticks"], out["ticks_drive"] = 100 + self.k, self.k
        self.weights.append(out["x"]["k_s"].copy())
        if self.k in self.wrong:
            out.view(np.uint32).reshape(n, -1)[self.wrong[self.k], [7, 9]] ^= 1
        self.k += 1
        return out


def test_words_are_compared_while_a_drive_lives() -> None:
    """For 12 and 8 periods; two words of the second drive are wrong in two, and after its end."""
    some = cut(lambda: pil_scenarios(PAPER, 5, 10)[1], 0.01)()
    sims = SimFactory(PAPER, DriveDesign()).build(some)[:2].copy()
    sims["k_end"] = [12, 8]
    host = Host(sims, {2: 1, 6: 1, 10: 1})
    table = KsTable((Axis("speed", 0.0, 0.5, 2),), np.full(2, 0.25, dtype=np.float32))
    found = lockstep(host, sims, table, 5)  # type: ignore[arg-type]
    assert found.periods.tolist() == [12, 8]
    assert found.mismatches.tolist() == [0, 4] and found.first == (1, 2, 7)
    assert found.ticks.shape == (20, 2) and found.ticks[-1].tolist() == [111, 11]
    first = np.array(host.weights)[:, 0]
    assert found.k_s[0] == pytest.approx([first.min(), first.max()]) and np.ptp(first) > 0.0


@pytest.mark.parametrize("n", [0, DRIVES + 1])
def test_no_drives_and_too_many_are_refused(n: int) -> None:
    some = SimFactory(PAPER, DriveDesign()).build(pil_scenarios(PAPER, 5, 9)[1])
    table = KsTable((Axis("speed", 0.0, 0.5, 2),), np.zeros(2, dtype=np.float32))
    with pytest.raises(ValueError, match=f"{n} drives; give 1 to 64"):
        lockstep(None, np.resize(some, n), table, 5)  # type: ignore[arg-type]
    assert WORDS > 20


def test_as_many_drives_as_a_request_holds() -> None:
    sims = np.resize(SimFactory(PAPER, DriveDesign()).build(pil_scenarios(PAPER, 5, 9)[1]), DRIVES)
    sims = sims[np.zeros(DRIVES, dtype=int)]
    sims["k_end"] = 1
    table = KsTable((Axis("speed", 0.0, 0.5, 2),), np.full(2, 0.25, dtype=np.float32))
    found = lockstep(Host(sims, {}), sims, table, 5)  # type: ignore[arg-type]
    assert found.periods.tolist() == [1] * DRIVES and found.first is None


def test_the_stack_is_the_deepest_way_through_the_calls(tmp_path: Path) -> None:
    """100 + max(20 + 7, 30) and 90 + 30."""
    nodes = {"step": 100, "a": 20, "b": 30, "c": 7, "other": 90}
    text = "".join(f'node: {{ title: "{k}" label: "{k}\\n{v} bytes (static)" }}\n'
                   for k, v in nodes.items())  # fmt: skip
    calls = [("step", "a"), ("step", "b"), ("a", "c"), ("other", "b"), ("b", "sqrtf")]
    text += "".join(f'edge: {{ sourcename: "{a}" targetname: "{b}" }}\n' for a, b in calls)
    (tmp_path / "one.ci").write_text(text)
    assert tools.stack_of(tmp_path, ("step", "other")) == 130
    assert tools.stack_of(tmp_path, ("other", "step")) == 130
    assert tools.stack_of(tmp_path, ("other",)) == 120


def told(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    """Whatever program is run tells this."""
    monkeypatch.setattr(subprocess, "run", lambda *_, **__: SimpleNamespace(stdout=text))


def test_what_the_compiler_s_programs_tell(monkeypatch: pytest.MonkeyPatch) -> None:
    told(monkeypatch, ".text 4 0\n.text.a 96 0\n.rodata.b 8 0\n.comment 50 0\n.bss 12 0\n")
    assert tools.sections(Path("x.o")) == {"text": 100, "rodata": 8, "bss": 12}
    told(monkeypatch, "00000000 0000001c T step\n00000010 00000100 R values\n         U sqrtf\n")
    assert tools.symbol_sizes(Path("x.o")) == {"step": 28, "values": 256}
    lines = [f"  80:\tee\t{x}.f32\ts0, s1" for x in ("vfma", "vfms", "vfnma", "vfnms", "vmla")]
    told(monkeypatch, "\n".join(lines))
    assert tools.fused_instructions(Path("image.elf")) == 4


def test_the_memory_of_a_product(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The tables are header and values; what checks them is all but the lookups."""
    sizes = {"ks_table_f32": 20, "ks_values_f32": 100, "ks_table_q15": 30, "ks_values_q15": 50,
             "ks_table_check": 7, "crc": 5, "eval_f32": 1000, "ks_table_eval": 2000}  # fmt: skip
    monkeypatch.setattr(tools, "symbol_sizes", lambda _: sizes)
    monkeypatch.setattr(tools, "sections", lambda path: {"text": len(path.name)})
    found = tools.memory(tmp_path)
    assert found["table_f32"] == {"rodata": 120} and found["table_q15"] == {"rodata": 80}
    assert found["table_check"] == {"text": sum(sizes.values()) - 3000}
    assert {"drive.o", "ks_table.o", "ks_schedule.o"} <= set(found)
    assert not [name for name in found if "selftest" in name or "bring_up" in name]


def test_the_report_counts_what_was_lost() -> None:
    names = ("policy", "motor", "estimator")
    report: dict[str, Any] = dict.fromkeys(names, "smo") | dict.fromkeys(
        ("periods", "mismatches", "lookups", "lookup_mismatches", "fused_instructions",
         "flash_core", "flash_table_and_check", "ram_state", "stack"), 0
    )  # fmt: skip
    report |= {"target_tests": {"a": 2, "b": 3}, "instructions": {}, "level": "-O2"}
    report["scenarios"] = [{"name": "x", "lost": None}, {"name": "y", "lost": "angle"}]
    report["memory"] = {"drive.o": {"text": 1234, "bss": 0}}
    columns = [list(column.cells) for column in report_table(report).columns]
    rows = {str(cells[0]).strip(): str(cells[-1]) for cells in zip(*columns, strict=True)}
    assert rows["failed tests on the target"] == "5" and rows["scenarios"] == "2"
    assert rows["lost: y (angle)"] == "1"
    assert "drive.o: text 1,234" in rows
