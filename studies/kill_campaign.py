"""Kill train, tune, export and report at random times, and see that all they show is complete.

    python studies/kill_campaign.py --kills 50 --out build/kills.json

Each command runs in a process of its own over what the one before it left, and is killed (one time
in four by SIGTERM, else by SIGKILL) at a random time of its usual duration. Then every file that
has its final name must be whole: JSON and CSV parse, archives and pictures have their checksums, an
export has the sums that it lists, a page has its end. A training run must resume, or start anew
under its name. The logs of TensorBoard, which grow line by line, are left out. Exit status 1 if
anything is broken.
"""

import argparse
import csv
import hashlib
import json
import os
import random
import signal
import sys
import tempfile
import time
import zipfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sensorless.cli.main import main as sensorless
from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.files import is_part, write_atomic

SMALL = "--n-envs 16 --n-steps 16 --n-epochs 1 --validate-size 16 --eval-freq 256"
COMMANDS = {
    "train": f"train --name killed --steps 4096 {SMALL}",
    "tune": "tune linear --budget 800 --out tuned.json",
    "export": "export eq25 --out exported --no-fit",
    "report": "report eq25 --out report --suite nominal --size 4 --grid 2 --policy eq25",
}
RUN = Path("runs/killed")
RESUME = f"train --resume {RUN} --steps 256"


def start(words: str) -> int:
    """Run a command in a copy of this process, in silence; returns its number."""
    child = os.fork()
    if child:
        return child
    status = 70
    try:
        null = os.open(os.devnull, os.O_RDWR)
        for stream in (0, 1, 2):
            os.dup2(null, stream)
        sys.argv = ["sensorless", *words.split()]
        sensorless()
        status = 0
    except SystemExit as stop:
        status = stop.code if isinstance(stop.code, int) else 1
    finally:
        os._exit(status)


def finished(words: str) -> tuple[int, float]:
    """Exit status of a command, and how long it took [s]."""
    began = time.monotonic()
    _, status = os.waitpid(start(words), 0)
    return os.waitstatus_to_exitcode(status), time.monotonic() - began


def killed(words: str, after: float, number: signal.Signals) -> int:
    """Exit status of a command to which a signal comes after a while [s]."""
    child = start(words)
    time.sleep(after)
    os.kill(child, number)  # a child that has ended waits to be asked for
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def broken(folder: Path) -> Iterator[str]:
    """Files below a folder that have their final name and are not whole, with the reason."""
    for path in sorted(folder.rglob("*")):
        parts = path.relative_to(folder).parts
        if path.is_dir() or "tb" in parts or any(is_part(name) for name in parts):
            continue
        try:
            _read(path)
        except Exception as error:  # whatever a reader says of half a file
            yield f"{path.relative_to(folder)}: {type(error).__name__}: {error}"


def _read(path: Path) -> None:
    """Read a file to its end.

    Raises
    ------
    Exception
        It is not whole.
    """
    if path.suffix == ".json":
        json.loads(path.read_text(encoding="utf-8"))
    elif path.suffix == ".csv":
        text = path.read_text(encoding="utf-8")
        if not text.endswith("\n") or len({len(row) for row in csv.reader(text.splitlines())}) != 1:
            raise ValueError("rows of unequal length")
    elif path.suffix == ".zip":
        with zipfile.ZipFile(path) as archive:
            if archive.testzip() is not None:
                raise ValueError("wrong checksum")
    elif path.suffix == ".png":
        from PIL import Image

        with Image.open(path) as picture:
            picture.load()
    elif path.suffix == ".html":
        if not path.read_text(encoding="utf-8").rstrip().endswith("</html>"):
            raise ValueError("no end")
    elif path.name == "SHA256SUMS":
        for line in path.read_text(encoding="utf-8").splitlines():
            digest, name = line.split(maxsplit=1)
            if hashlib.sha256((path.parent / name.lstrip("*")).read_bytes()).hexdigest() != digest:
                raise ValueError(f"{name} has another sum")


def again() -> str:
    """Go on with the training run that was killed; the reason if that fails."""
    if not RUN.exists():
        return ""
    if finished(RESUME)[0] == 0 or finished(COMMANDS["train"])[0] == 0:
        return ""
    return "train: neither --resume nor the same --name goes on"


def campaign(kills: int, seed: int) -> dict[str, Any]:
    """Kill the commands in turn in this folder; what happened."""
    draw = random.Random(seed)
    lasts = {name: finished(words) for name, words in COMMANDS.items()}
    failed = [name for name, (status, _) in lasts.items() if status]
    if failed:
        raise SystemExit(f"error: {failed} failed without being killed")
    found: list[str] = []
    ends: Counter[str] = Counter()
    for kill in range(kills):
        name = list(COMMANDS)[kill % len(COMMANDS)]
        if name == "train" and RUN.exists():
            RUN.rename(RUN.with_name(f"killed-{kill}"))
        number = signal.SIGTERM if draw.random() < 0.25 else signal.SIGKILL
        status = killed(COMMANDS[name], draw.random() * lasts[name][1], number)
        ends[f"{name} {status}"] += 1
        found += [f"kill {kill}, {name}: {text}" for text in broken(Path())]
        if name == "train" and (reason := again()):
            found.append(f"kill {kill}, {reason}")
    parts = [str(path) for path in Path().rglob("*") if is_part(path.name)]
    return {
        "kills": kills,
        "seed": seed,
        "seconds": {name: round(seconds, 2) for name, (_, seconds) in lasts.items()},
        "exit_statuses": dict(sorted(ends.items())),
        "half_written_and_hidden": len(parts),
        "broken": found,
    }


def main() -> int:
    """Run the campaign; status 1 if anything is broken."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--kills", type=a_count, default=50)
    parser.add_argument("--seed", type=a_seed, default=1)
    parser.add_argument("--out", type=Path, help="write what happened as JSON")
    words = parser.parse_args()
    out = None if words.out is None else words.out.resolve()
    import sensorless.agents.train.train
    import sensorless.plots.waveforms  # noqa: F401  (loaded once, before the copies)
    from sensorless.evaluation import compare
    from sensorless.export import judge

    compare.SIZE = judge.SIZE = 16  # verdicts, which write nothing, are made on fewer scenarios
    with tempfile.TemporaryDirectory() as place:
        before = Path.cwd()
        os.chdir(place)
        try:
            found = campaign(words.kills, words.seed)
        finally:
            os.chdir(before)
    print(json.dumps(found, indent=1))
    if out is not None:
        out.parent.mkdir(parents=True, exist_ok=True)
        write_atomic(out, json.dumps(found, indent=1) + "\n")
    return int(bool(found["broken"]))


if __name__ == "__main__":
    sys.exit(main())
