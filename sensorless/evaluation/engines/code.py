"""What the bits of a result depend on besides its inputs, to compare two computers."""

import hashlib
import os
from functools import lru_cache
from pathlib import Path

import numpy as np

import sensorless
from sensorless.versions import versions


@lru_cache
def code() -> dict[str, str]:
    """Versions of package, core and libraries; digests of the sources and NumPy's arithmetic."""
    known = {name: value for name, value in versions().items() if name != "python"}
    return {**known, "sources": _sources(), "arithmetic": arithmetic()}


def difference(here: dict[str, str], there: dict[str, str]) -> str:
    """Name what differs, with both values; empty if nothing does."""
    return ", ".join(
        f"{name} {there.get(name, 'none')[:12]} instead of {value[:12]}"
        for name, value in here.items()
        if there.get(name) != value
    )


def _sources() -> str:
    """Digest of every Python file of the package, which may be links to folders elsewhere."""
    root, digest = Path(sensorless.__file__).parent, hashlib.sha256()
    files = [
        (Path(folder) / name).relative_to(root)
        for folder, _, names in os.walk(root, followlinks=True)
        for name in names
        if name.endswith(".py")
    ]
    for file in sorted(files):
        digest.update(f"{file.as_posix()}\n".encode() + (root / file).read_bytes())
    return digest.hexdigest()


def arithmetic() -> str:
    """Digest of functions for which NumPy uses different instructions on different processors."""
    x = np.linspace(-3.0, 3.0, 1001)
    digest = hashlib.sha256()
    for values in (x, x.astype(np.float32)):
        for f in (np.exp, np.sin, np.cos, np.tanh, np.arctan, np.log1p):
            digest.update(f(np.abs(values) if f is np.log1p else values).tobytes())
        digest.update(values.sum().tobytes() + np.square(values).mean().tobytes())
        digest.update((values[:960].reshape(64, 15) @ values[:240].reshape(15, 16)).tobytes())
    return digest.hexdigest()
