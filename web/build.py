"""Builds the playground: one HTML file that needs no network.

Usage: python -m web.build [FILE], build/playground/playground.html by default.
"""

import argparse
import sys
from pathlib import Path

from sensorless.errors import UserError
from sensorless.files import write_atomic
from web.assemble import page
from web.image import image
from web.wasm import BUILD, compile_core

MOST_BYTES = 400_000
"""Largest page [bytes]."""


def build(path: Path) -> int:
    """Write the page; return its size [bytes].

    Raises
    ------
    UserError
        A program is not installed, the core does not compile, or the page is too large.
    """
    text = page(compile_core(), *image())
    size = len(text.encode())
    if size > MOST_BYTES:
        raise UserError(f"playground: {size} bytes; shorten it to {MOST_BYTES}")
    path.parent.mkdir(parents=True, exist_ok=True)
    write_atomic(path, text)
    return size


def main() -> None:
    """Build the file that the command line names."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("page", type=Path, nargs="?", default=BUILD / "playground.html")
    path = parser.parse_args().page
    try:
        print(f"wrote {path}, {build(path) / 1000:.0f} kB")
    except UserError as error:
        sys.exit(f"error: {error}")


if __name__ == "__main__":
    main()
