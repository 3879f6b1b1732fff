"""Speed beside gym-electric-motor and motulator, measured in one run: ``make bench-peers``.

Each peer gets a virtual environment of its own in ``build/peers``, with the version pinned here.
Everything runs one after the other, one thread each. Rates are steps per second of processor time,
which other programs on the machine hardly change. Ratios are core against core; beside them stands
the whole machine: our drives in one process for every core at once against the peer as it comes,
which is one process. Writes ``build/bench-peers.json``.
"""

import argparse
import json
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sensorless.errors import UserError
from sensorless.files import write_atomic

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "build" / "peers"

PEERS = {
    "gem": ("gym-electric-motor==3.0.3", (3, 10)),
    "motulator": ("motulator==0.18.0", (3, 12)),
}
"""What to install, and the least Python."""

WHAT = {
    "gem": "one PMSM without saturation at constant speed, averaged converter; no controller, no "
    "observer; a step is 200 us",
    "motulator": "one IPMSM without saturation, converter, sensorless control with a flux observer "
    "or with injection; exact sensors; a period is 125 us",
    "machine alone": "one saturated IPMSM and its mechanics, Runge-Kutta; a step is 200 us",
    "drive": "256 IPMSM drives in blocks: saturated machine, inverter with dead time, ADC and "
    "sensor errors, injection, coupled observer, control; a period is 200 us",
    "drive and its sensored twin": "the same, and beside each a drive that knows its angle",
}

COMPARED = (
    ("plant steps", "machine alone", "gem", "environment, euler", None),
    ("plant steps inside a whole drive", "drive", "gem", "environment, euler", 1000.0),
    ("plant steps inside a whole drive", "drive", "gem", "environment, scipy", 1000.0),
    ("control periods", "drive", "motulator", "flux observer, averaged", 5000.0),
    (
        "control periods, the twin's not counted",
        "drive and its sensored twin",
        "motulator",
        "flux observer, averaged",
        5000.0,
    ),
    ("control periods", "drive", "motulator", "injection, PWM and dead time", None),
)
"""What is counted, our variant, peer, its variant (scipy is the default solver of GEM, Euler its
fastest), and the ratio that the whole machine is to reach."""


def pythons() -> Iterator[str]:
    """Interpreters to try, the one that runs this first."""
    if wish := os.environ.get("PEERS_PYTHON"):
        yield wish
    yield sys.executable
    names = [f"python3.{minor}" for minor in range(20, 9, -1)]
    yield from (path for name in names if (path := shutil.which(name)))
    installed = Path.home().glob(".pyenv/versions/3.*/bin/python3")
    yield from (str(path) for path in sorted(installed))


def python_for(least: tuple[int, int]) -> str:
    """Interpreter of at least that version which can make virtual environments."""
    asks = f"import ensurepip, sys; sys.exit(sys.version_info < {least})"
    for python in pythons():
        try:
            done = subprocess.run([python, "-c", asks], capture_output=True, check=False)
        except OSError:
            continue
        if done.returncode == 0:
            return python
    wanted = ".".join(map(str, least))
    raise UserError(f"python: none of {wanted} or newer found; set PEERS_PYTHON to its path")


def install(peer: str) -> str:
    """Interpreter of the peer's virtual environment, made if it is not there.

    Raises
    ------
    UserError
        No Python for it, or the package cannot be had.
    """
    package, least = PEERS[peer]
    folder = FOLDER / peer
    python, stamp = folder / "bin" / "python", folder / f".{package}"
    if stamp.exists():
        return str(python)
    print(f"installing {package} into {folder.relative_to(ROOT)}", flush=True)
    base = python_for(least)
    env = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    for words in (
        [base, "-m", "venv", "--clear", str(folder)],
        [str(python), "-m", "pip", "install", "--quiet", package],
    ):
        done = subprocess.run(words, env=env, capture_output=True, text=True, check=False)
        if done.returncode:
            said = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
            raise UserError(
                f"{package}: cannot be installed ({said[0] if said else 'see pip'}); "
                "check that pip reaches the package index"
            )
    stamp.touch()
    return str(python)


def start(python: str, module: str, *words: str) -> "subprocess.Popen[str]":
    """Runner in one thread, without progress bars or windows."""
    single = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "SENSORLESS_THREADS")
    quiet = {"TQDM_DISABLE": "1", "MPLBACKEND": "Agg", "PYTHONPATH": str(ROOT)}
    return subprocess.Popen(
        [python, "-m", f"benchmarks.{module}", *words],
        cwd=ROOT,
        env={**os.environ, **dict.fromkeys(single, "1"), **quiet},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def parse(name: str, status: int, out: str, err: str) -> dict[str, Any]:
    """Figures that a runner printed in its last line.

    Raises
    ------
    UserError
        It failed.
    """
    lines = out.strip().splitlines()
    if status or not lines:
        reason = (err.strip().splitlines() or ["no output"])[-1]
        raise UserError(f"{name}: stopped with status {status} ({reason})")
    told: dict[str, Any] = json.loads(lines[-1])
    return told


def finish(name: str, runner: "subprocess.Popen[str]") -> dict[str, Any]:
    """Result of a runner, when it has ended."""
    out, err = runner.communicate()
    return parse(name, runner.returncode, out, err)


def ratios(found: dict[str, Any]) -> list[dict[str, Any]]:
    """Every comparison of COMPARED, by core and for the whole machine."""
    rows = []
    for what, variant, peer, theirs, wanted in COMPARED:
        ours, other = found["ours"]["rates"][variant], found[peer]["rates"][theirs]
        whole = found["all cores"].get(variant)
        rows.append(
            {
                "what": what,
                "ours": variant,
                "peer": f"{peer}: {theirs}",
                "core_to_core": ours["per_cpu_s"] / other["per_cpu_s"],
                "machine_to_process": None if whole is None else whole / other["per_cpu_s"],
                "wanted": wanted,
            }
        )
    return rows


def measure() -> dict[str, Any]:
    """All rates, one runner after the other, and our drives on all cores at once."""
    installed = {peer: install(peer) for peer in PEERS}
    found: dict[str, Any] = {"ours": finish("ours", start(sys.executable, "peer_ours"))}
    for peer, python in installed.items():
        found[peer] = finish(peer, start(python, f"peer_{peer}"))
    cores = len(os.sched_getaffinity(0))
    runners = [start(sys.executable, "peer_ours", "drives") for _ in range(cores)]
    each = [finish("ours", runner)["rates"] for runner in runners]
    found["all cores"] = {name: sum(r[name]["per_cpu_s"] for r in each) for name in each[0]}
    return {"machine": platform.machine(), "cores": cores, "what": WHAT, **found}


def report(found: dict[str, Any]) -> str:
    """Rates and ratios as text."""
    lines = []
    for who in ("ours", *PEERS):
        versions = ", ".join(f"{name} {v}" for name, v in found[who]["versions"].items())
        lines.append(f"{who} ({versions}), one thread, per second of processor time:")
        for name, told in found[who]["rates"].items():
            lines.append(f"  {name:34} {told['per_cpu_s']:14,.0f}")
    lines.append(f"ours on {found['cores']} cores at once, per second of processor time of each:")
    lines += [f"  {name:34} {value:14,.0f}" for name, value in found["all cores"].items()]
    for row in found["ratios"]:
        whole, wanted = row["machine_to_process"], row["wanted"]
        lines.append(f"{row['what']}: {row['ours']} over {row['peer']}")
        told = f"  core to core {row['core_to_core']:,.0f}"
        if whole is not None:
            told += f", {found['cores']} cores to one process {whole:,.0f}"
        lines.append(told + (f" (wanted: {wanted:,.0f})" if wanted else ""))
    return "\n".join(lines)


def main() -> int:
    """Measure, print, and write the file."""
    argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0]).parse_args()
    try:
        found = measure()
    except UserError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    found["ratios"] = ratios(found)
    print(report(found))
    out = ROOT / "build" / "bench-peers.json"
    write_atomic(out, json.dumps(found, indent=1) + "\n")
    print(f"wrote {out.relative_to(ROOT)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
