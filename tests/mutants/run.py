"""Which small mistakes in the control core that ships do the checks notice: a mutation campaign.

    python -m tests.mutants.run [--size 400 | --all] [--seed 1] [--out FILE.json]

Each mutant of ``mutate.py`` is compiled with the checks of this folder, which compare every stage
with its equations, and whole drives with what they must do in a closed loop. A mutant dies by a
check, or only by the sum over the states of recorded trajectories, which says no more than that
something changed; the record counts both. Mutants that do not compile, or give the same machine
code, are not viable. ``survivors.json`` explains those that live.
"""

import argparse
import json
import random
import shutil
import subprocess
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

from tests.mutants.build import (
    DRIVE,
    FLAGS,
    OBJECTS,
    ROOT,
    compile_checks,
    run_checks,
    write_params,
)
from tests.mutants.mutate import Mutant, all_mutants

EXPLAINED = Path(__file__).with_name("survivors.json")


class Bench:
    """A copy of the core in which one mutant at a time stands."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.drive = folder, folder / "drive"
        shutil.copytree(DRIVE, self.drive)
        write_params(folder)
        program = compile_checks(self.drive, folder)
        if program is None:
            raise SystemExit("the checks do not compile with the core as it is")
        failed, self.sum = run_checks(program)
        if failed:
            raise SystemExit(f"the core as it is fails: {', '.join(failed)}")
        self.code = self._code()

    def _code(self) -> bytes | None:
        """Machine code as it ships, to find mutants that change nothing."""
        text = b""
        for name in OBJECTS:
            out = self.folder / f"{name}.o"
            command = ["cc", *FLAGS, "-O1", "-w", "-c", f"{name}.c", "-o", str(out)]
            if subprocess.run(command, cwd=self.drive, capture_output=True, check=False).returncode:
                return None
            text += out.read_bytes()
        return text

    def judge(self, mutant: Mutant) -> tuple[str, list[str]]:
        """``check``, ``sum``, ``lives``, ``same`` or ``invalid``, and the failed checks."""
        path = self.drive / mutant.file
        original = path.read_text(encoding="utf-8")
        path.write_text(mutant.text, encoding="utf-8")
        try:
            program = compile_checks(self.drive, self.folder)
            if program is None:
                return "invalid", []
            failed, total = run_checks(program)
            if failed:
                return "check", failed
            if total != self.sum:
                return "sum", []
            return ("same" if self._code() == self.code else "lives"), []
        finally:
            path.write_text(original, encoding="utf-8")


def summary(found: list[tuple[Mutant, str, list[str]]], reasons: dict[str, str]) -> dict[str, Any]:
    """Counts, and every viable mutant that no check noticed."""
    count = Counter(verdict for _, verdict, _ in found)
    viable = count["check"] + count["sum"] + count["lives"]
    equal = sum(v == "lives" and reasons.get(m.after, "").startswith("same") for m, v, _ in found)
    dead = count["check"] + count["sum"]
    return {
        "mutants": len(found),
        "invalid": count["invalid"],
        "same_code": count["same"],
        "viable": viable,
        "dead_by_a_check": count["check"],
        "dead_by_the_sum_alone": count["sum"],
        "alive": count["lives"],
        "alive_without_effect": equal,
        "dead_pct": round(100.0 * dead / max(viable - equal, 1), 2),
        "by_checks_pct": round(100.0 * count["check"] / max(viable - equal, 1), 2),
        "survivors": [
            {"where": m.name, "before": m.before, "after": m.after,
             "why": reasons.get(m.after, "not explained")}
            for m, verdict, _ in found if verdict == "lives"
        ],
        "by_the_sum": [
            {"where": m.name, "after": m.after} for m, verdict, _ in found if verdict == "sum"
        ],
    }  # fmt: skip


def main() -> None:
    """Run, print and record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--size", type=int, default=400, help="mutants drawn")
    parser.add_argument("--all", action="store_true", help="every mutant; hours")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=20.0, help="most time, without --all")
    parser.add_argument("--out", type=Path, default=ROOT / "results" / "studies" / "mutants.json")
    options = parser.parse_args()
    chosen, start = all_mutants(DRIVE), time.monotonic()
    total = len(chosen)
    if not options.all:
        chosen = random.Random(options.seed).sample(chosen, min(options.size, total))
    reasons = json.loads(EXPLAINED.read_text(encoding="utf-8"))
    found: list[tuple[Mutant, str, list[str]]] = []
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(Path(folder))
        for mutant in chosen:
            if not options.all and time.monotonic() - start > 60.0 * options.minutes:
                break
            verdict, failed = bench.judge(mutant)
            found.append((mutant, verdict, failed))
            if verdict in ("sum", "lives"):
                print(f"{verdict:5} {mutant.name}: {mutant.after}", flush=True)
    record = {"seed": options.seed, "of": total, **summary(found, reasons)}
    options.out.parent.mkdir(parents=True, exist_ok=True)
    options.out.write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
    print({key: value for key, value in record.items() if not isinstance(value, list)})


if __name__ == "__main__":
    main()
