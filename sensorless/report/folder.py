"""The files of a report, and what it may replace: only what a report has written before."""

from collections.abc import Iterable
from pathlib import Path

from sensorless.errors import UserError
from sensorless.files import read_json

PAGE = "index.html"


def results_file(folder: Path, suite: str) -> Path:
    """Where the numbers of a suite go."""
    return folder / f"results-{suite}.json"


def keep_other_files(folder: Path, suites: Iterable[str]) -> None:
    """Refuse a folder in which a file of somebody else would be replaced.

    Every report's page has its commands in it, and its results have no single scenarios, which
    those of ``sensorless evaluate`` have.

    Raises
    ------
    UserError
        Page or results are not those of a report.
    """
    page = folder / PAGE
    files = [page] if page.is_file() and b"sensorless report" not in page.read_bytes() else []
    files += [file for suite in suites if not _replaceable(file := results_file(folder, suite))]
    for file in files:
        raise UserError(
            f"out: {str(file)!r} exists and is no report; give a new folder, or move it away"
        )


def _replaceable(file: Path) -> bool:
    """Whether there is no such file, or one that a report wrote."""
    if not file.exists():
        return True
    try:
        policies = read_json(file)["policies"]
        return not any("scenarios" in policy for policy in policies.values())
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return False
