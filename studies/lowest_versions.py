"""Run tests on the lowest versions that pyproject.toml allows: ``make test-lowest``.

    python studies/lowest_versions.py [TESTS ...]

Makes build/lowest with them (torch alone is as installed here, because its older wheels come with a
gigabyte of GPU libraries), and runs the tests there on the core that is already compiled. What is
said depends on libraries most: the command line, tables, policies, training, logs, environments.
"""

import argparse
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib.metadata import version
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[1]
PLACE = ROOT / "build" / "lowest"
EXTRAS = ("plot", "tune", "fuzzy", "scale")
TESTS = (
    "tests/cli/test_cli.py", "tests/test_files.py", "tests/replay", "tests/agents", "tests/table",
    "tests/envs", "tests/policies",
)  # fmt: skip
REQUIREMENT = re.compile(r"([\w-]+)>=([\d.]+)")


def lowest(project: Path) -> Iterator[str]:
    """Every requirement at its lowest version; the last patch of it, where none is named."""
    data = tomllib.loads(project.read_text(encoding="utf-8"))["project"]
    extras = data["optional-dependencies"]
    for line in [*data["dependencies"], *(word for name in EXTRAS for word in extras[name])]:
        if (found := REQUIREMENT.match(line)) is None:
            raise SystemExit(f"error: {line!r} names no lowest version")
        name, least = found.groups()
        if name == "torch":
            yield f"torch=={version('torch').split('+')[0]}"
        elif ";" not in line:
            yield f"{name}=={least}" + (".*" if least.count(".") < 2 else "")


def main() -> int:
    """Make the environment, run the tests, return pytest's status."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("tests", nargs="*", default=TESTS, help="as pytest takes them")
    words = parser.parse_args()
    python = PLACE / "bin" / "python"
    wanted = list(lowest(ROOT / "pyproject.toml"))
    print("lowest versions:", ", ".join(wanted), flush=True)
    subprocess.run([sys.executable, "-m", "venv", PLACE], check=True)
    subprocess.run(
        [python, "-m", "pip", "install", "-q", "--no-compile", *wanted, "pytest"], check=True
    )
    place = {**os.environ, "PYTHONPATH": str(ROOT)}
    command = [str(python), "-m", "pytest", "-q", "-p", "no:cacheprovider", *words.tests]
    return subprocess.run(command, cwd=ROOT, env=place, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
