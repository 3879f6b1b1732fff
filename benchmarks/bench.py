"""Speed and memory of core, evaluation, environments and training, also to ``build/bench.json``.

Usage: python -m benchmarks.bench [SECONDS], the least time for a variant, 3 by default.
"""

import json
import os
import platform
from collections.abc import Callable
from pathlib import Path
from typing import Any

from benchmarks import core_speed, env_speed, evaluation_speed, memory, training_speed
from benchmarks.words import parser
from sensorless.core.api import ffi, lib
from sensorless.files import write_atomic


def processor() -> str:
    """Model name of the processor, where the system tells."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.machine()


def show(title: str, entries: dict[str, Any], indent: str = "") -> None:
    """Print names and figures, one a line."""
    print(f"{indent}{title}")
    for name, value in entries.items():
        if isinstance(value, dict):
            show(name, value, indent + "  ")
        else:
            text = f"{value:,.3g}" if isinstance(value, float) and value < 1e4 else value
            text = f"{value:,.0f}" if isinstance(value, float) and value >= 1e4 else text
            print(f"{indent}  {name:32} {text}", flush=True)


def main() -> None:
    """Measure all parts."""
    words = parser(__doc__)
    words.add_argument("seconds", nargs="?", type=float, default=3.0, help="time for a variant [s]")
    seconds = float(words.parse_args().seconds)
    result: dict[str, Any] = {
        "machine": processor(),
        "cores": os.cpu_count(),
        "python": platform.python_version(),
        "core": ffi.string(lib.core_hash).decode(),
    }
    show("machine", result)
    parts: dict[str, Callable[[], dict[str, Any]]] = {
        "core": lambda: core_speed.measure(seconds),
        "evaluation": lambda: evaluation_speed.measure(2.0 * seconds),
        "environments": lambda: env_speed.measure(seconds),
        "memory": memory.measure,
        "training": lambda: training_speed.measure(4.0 * seconds),
    }
    for name, measure in parts.items():
        result[name] = measure()
        show(name, result[name])
    out = Path("build/bench.json")
    out.parent.mkdir(exist_ok=True)
    write_atomic(out, json.dumps(result, indent=1) + "\n")
    print(f"wrote {out}")


if __name__ == "__main__":
    main()
