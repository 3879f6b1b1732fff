"""What the drive loses on motors whose files were made from published numbers.

    python studies/datasheet_study.py [--size 200] [--seed 1]

Makes a file of each machine of ``tests/data/datasheets.toml`` with ``sensorless motor new``, and
judges Eq. 25 on it in ``nominal`` and ``stress``. Writes ``results/studies/datasheets.json``.
"""

import argparse
import sys
import tempfile
from pathlib import Path

from rich.console import Console
from rich.table import Table
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.cli.study_numbers import a_count, a_seed
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.scenario import SimFactory
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.errors import in_one_line
from sensorless.evaluation.evaluate import score
from sensorless.files import ensure_writable, write_record
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from sensorless.versions import versions

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).resolve().parents[1]
SHEETS = ROOT / "tests" / "data" / "datasheets.toml"
SUITES = ("nominal", "stress")


def file_of(name: str, options: dict[str, str], folder: Path) -> Motor | None:
    """The motor that ``motor new`` makes of the options; None: it refuses them."""
    path = folder / f"{name}.toml"
    words = [word for key, value in options.items() for word in (f"--{key}", value)]
    new = ["motor", "new", "--name", name, "--out", str(path), "--size", "0", *words]
    CliRunner().invoke(app, new)
    return Motor.load(str(path)) if path.is_file() else None


def lost(motor: Motor, suite: str, size: int, seed: int) -> int:
    """Scenarios that the default drive loses under Eq. 25."""
    rows = SuiteRows(suite, motor, seed, size)
    found = score(make_policy("eq25", motor), rows, SimFactory(motor, DriveDesign()))
    return int((found.lost != 0).sum())


def main() -> None:
    """Run, print and record."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("--size", type=a_count, default=200)
    parser.add_argument("--seed", type=a_seed, default=1)
    parser.add_argument("--out", type=Path, default=ROOT / "results/studies/datasheets.json")
    options = parser.parse_args()
    ensure_writable(options.out.parent)
    table = Table("machine", *(f"lost, {suite}" for suite in SUITES))
    found: dict[str, dict[str, int] | None] = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, sheet in tomllib.loads(SHEETS.read_text(encoding="utf-8")).items():
            motor = file_of(name, sheet["options"], Path(folder))
            found[name] = None
            if motor is not None:
                found[name] = {s: lost(motor, s, options.size, options.seed) for s in SUITES}
            counts = found[name]
            table.add_row(name, *(map(str, counts.values()) if counts else "–" * len(SUITES)))
    Console().print(table)
    record = {"size": options.size, "seed": options.seed, "versions": versions(), "lost": found}
    write_record(options.out, record)


if __name__ == "__main__":
    in_one_line(main)
