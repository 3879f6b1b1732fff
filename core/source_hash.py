"""Hash of the sources that the compiled core is built from."""

import hashlib
from pathlib import Path

CORE = Path(__file__).resolve().parent
FIRMWARE = CORE.parent / "firmware"
WIRE = FIRMWARE / "pil_wire.h"
"""Layout of the messages to and from a target, which the host's binding includes."""


def source_hash() -> str:
    """SHA-256 over the names and contents of all C sources and headers, 16 hex digits."""
    digest = hashlib.sha256()
    for path in [*sorted(CORE.glob("*/*.[ch]")), WIRE]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]
