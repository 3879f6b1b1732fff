"""What the compiled core was built from."""

import hashlib
from pathlib import Path

CORE = Path(__file__).resolve().parent
FIRMWARE = CORE.parent / "firmware"
WIRE = FIRMWARE / "pil_wire.h"
"""Layout of what travels to and from a target: the host binds it too."""


def source_hash() -> str:
    """SHA-256 over the names and contents of all C sources and headers, 16 hex digits."""
    digest = hashlib.sha256()
    for path in [*sorted(CORE.glob("*/*.[ch]")), WIRE]:
        digest.update(path.name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]
