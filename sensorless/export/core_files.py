"""What of the control core goes to the target, and what its headers say about each number."""

import re
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
CORE = PACKAGE / "core" / "drive"
FIRMWARE = PACKAGE / "firmware"
SOURCES = ("drive.c", "drive_start.c", "ks_schedule.c", "ks_selftest.c", "ks_table.c")
"""With every header that one of them includes."""

_STRUCT = re.compile(r"typedef struct \{(.*?)\}\s*(\w+);", re.DOTALL)
_FIELD = re.compile(r"^\s*\w+ (\w+)(?:\[\w+\])?; */\*(.*?)\*/", re.MULTILINE | re.DOTALL)


def core_files() -> dict[str, bytes]:
    """Name and content of every core file that belongs on the target.

    Raises
    ------
    RuntimeError
        One of them is marked "Host only".
    """
    files: dict[str, bytes] = {}
    todo = list(SOURCES)
    while todo:
        name = todo.pop()
        if name in files:
            continue
        files[name] = (CORE / name).read_bytes()
        text = files[name].decode()
        if "Host only" in text:
            raise RuntimeError(f"core/{name} is host only, but a file of the target includes it")
        todo += re.findall(r'^#include "(.*)"', text, re.MULTILINE)
    return dict(sorted(files.items()))


def field_docs() -> dict[tuple[str, str], str]:
    """Comment of each struct field in the headers, by struct and field."""
    return {
        (struct, field): " ".join(doc.split())
        for content in core_files().values()
        for body, struct in _STRUCT.findall(content.decode())
        for field, doc in _FIELD.findall(body)
    }
