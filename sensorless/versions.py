"""What a result depends on besides its inputs: the command, and versions."""

import platform
import shlex
import sys
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, version

from sensorless import __version__
from sensorless.core.api import ffi, lib

LIBRARIES = ("numpy", "scipy")
"""Libraries that every evaluation computes with."""


def typed() -> str:
    """Command that the user typed."""
    return shlex.join(["sensorless", *sys.argv[1:]])


def versions(libraries: Iterable[str] = LIBRARIES) -> dict[str, str]:
    """Versions of this package, its compiled core (hash of its sources), Python and libraries."""
    return {
        "sensorless": __version__,
        "core": ffi.string(lib.core_hash).decode(),
        "python": platform.python_version(),
        **{name: _version(name) for name in libraries},
    }


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return "not installed"
