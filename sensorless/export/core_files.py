"""Files of the control core that go to the target, and what their headers say about each field."""

import re
from pathlib import Path

PACKAGE = Path(__file__).parents[1]
CORE = PACKAGE / "core" / "drive"
FIRMWARE = PACKAGE / "firmware"

_STRUCT = re.compile(r"typedef struct \{(.*?)\}\s*(\w+);", re.DOTALL)
_FIELD = re.compile(r"^\s*\w+ (\w+)(?:\[\w+\])?; */\*(.*?)\*/", re.MULTILINE | re.DOTALL)


def core_files(gains: bool = False) -> dict[str, bytes]:
    """Name and content of every file of the control core that an export needs.

    That is all of ``core/drive``, without what sets gains unless ``gains``.
    """
    return {
        path.name: path.read_bytes()
        for path in sorted(CORE.glob("*.[ch]"))
        if gains or not path.name.startswith("gain")
    }


def field_docs() -> dict[tuple[str, str], str]:
    """Comment of each struct field in the headers, by struct and field."""
    return {
        (struct, field): " ".join(doc.split())
        for content in core_files().values()
        for body, struct in _STRUCT.findall(content.decode())
        for field, doc in _FIELD.findall(body)
    }
