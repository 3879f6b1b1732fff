"""Where the nanoseconds of a batched PWM period go: instructions and samples by source file.

Usage: python -m benchmarks.inner_loop. Wants Linux's perf and binutils; the core carries line
numbers. The loop over the drives of a block is one straight run of instructions, so each one listed
is executed once a period (AVX-512) or twice (AVX2) for 16 drives.
"""

import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

from benchmarks.core_speed import LONG, core_loop
from benchmarks.words import parser
from sensorless import _core  # type: ignore[attr-defined]
from sensorless.core.api import lib

LOOP = "block_smo_twin"

HELPERS = ("frames.h", "trig.h", "curve.h", "pll.h", "signals.h")
"""Their instructions count for the stage that calls them."""

SECONDS = 5

FREQUENCY = 5000
"""Samples a second."""


def output(*command: str, text: str | None = None) -> str:
    """What a program prints."""
    return subprocess.run(
        command, input=text, capture_output=True, text=True, check=True
    ).stdout  # fmt: skip


def instructions() -> dict[int, str]:
    """Address and mnemonic of every instruction of the loop that this machine runs."""
    wanted = "zmm" if lib.sim_simd() == lib.SIMD_AVX512 else "ymm"
    for part in output("objdump", "-d", "--no-show-raw-insn", _core.__file__).split("\n\n"):
        if re.match(rf"[0-9a-f]+ <{LOOP}>:", part.strip()) and wanted in part:
            lines = re.findall(r"^\s+([0-9a-f]+):\s+(\S+)", part, re.MULTILINE)
            return {int(address, 16): mnemonic for address, mnemonic in lines}
    raise RuntimeError(f"no {LOOP} with {wanted} in {_core.__file__}")


def stages(addresses: list[int]) -> dict[int, str]:
    """Source file each address belongs to, helpers taken for their callers."""
    query = "\n".join(hex(a) for a in addresses) + "\n"
    text = output("addr2line", "-a", "-i", "-e", _core.__file__, text=query)
    found: dict[int, str] = {}
    address = 0
    for line in text.splitlines():
        if line.startswith("0x"):
            address = int(line, 16)
            continue
        name = Path(line.split(":")[0]).name
        if name not in HELPERS:
            found.setdefault(address, name)
    return found


def samples(known: dict[int, str]) -> Counter[int]:
    """Samples at each address while this program repeats the loop."""
    with tempfile.TemporaryDirectory() as folder:
        data = f"{folder}/perf.data"
        run = (sys.executable, "-m", "benchmarks.inner_loop", "repeat")
        output("perf", "record", "-q", "-e", "cpu-clock", "-F", str(FREQUENCY), "-o", data, *run)
        text = output("perf", "script", "-i", data, "-F", "ip,sym,symoff")
    first = min(known)
    offsets = re.findall(rf"{LOOP}\+0x([0-9a-f]+)", text)
    return Counter(first + int(offset, 16) for offset in offsets)


def repeat() -> None:
    """What is sampled: 64 drives with twins, on one thread."""
    run = core_loop(64, twin=True, periods=LONG, simd=lib.sim_simd())
    left = SECONDS * 10_000_000
    while left > 0:
        left -= run()


def main() -> None:
    """Print the table."""
    known = instructions()
    stage = stages(sorted(known))
    hits = samples(known)
    count = Counter(stage.get(a, "?") for a in known)
    time: Counter[str] = Counter()
    for address, n in hits.items():
        time[stage.get(address, "?")] += n
    whole = max(sum(time.values()), 1)
    print(f"{'source':20} {'instructions':>12} {'share of time':>14}")
    for name, n in time.most_common():
        print(f"{name:20} {count[name]:12d} {100.0 * n / whole:13.1f}%")
    print(f"{'all':20} {len(known):12d} {whole:8d} samples")
    kinds = Counter(mnemonic for mnemonic in known.values())
    print("most frequent:", ", ".join(f"{name} {n}" for name, n in kinds.most_common(12)))
    slow = {name: n for name, n in kinds.items() if name.startswith(("vdiv", "vsqrt"))}
    print("divisions and roots:", slow)


if __name__ == "__main__":
    words = parser(__doc__)
    words.add_argument("what", nargs="?", choices=["repeat"], help="run only what is sampled")
    repeat() if words.parse_args().what else main()
