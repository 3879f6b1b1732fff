"""The documentation's text, and the commands that it shows."""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("**/*.md"))]

FENCED = re.compile(r"^( *)```.*?\n(.*?)^ *```", re.DOTALL | re.MULTILINE)
INDENTED = re.compile(r"(?<=\n\n)(?: {4,}\S.*\n)+")


def text(page: Path) -> str:
    """Words of a page with one space between them."""
    return " ".join(page.read_text(encoding="utf-8").split())


def shown(page: Path) -> Iterator[tuple[list[str], bool]]:
    """Words of every command on a page, and whether it is whole; a span in a line may not be."""
    text = page.read_text(encoding="utf-8")
    blocks = [found.group(2) for found in FENCED.finditer(text)]
    prose = FENCED.sub("", text)
    blocks += [found.group() for found in INDENTED.finditer(prose)]
    for block in blocks:
        for line in re.sub(r"\\\n", " ", block).splitlines():
            if re.match(r" *(sensorless|make|python|pytest|\.venv/bin/\w+) ", line):
                yield shlex.split(line, comments=True), True
    for span in re.findall(r"`([^`]+)`", INDENTED.sub("", prose)):
        if re.match(r"(sensorless|make|python|pytest) ", span):
            yield shlex.split(span), False
