"""Draws the playground as the documentation shows it.

Usage: python -m web.picture [FILE], docs/playground.png by default.
"""

import sys
import tempfile
import time
from pathlib import Path

from web.browser import chromium, missing_browser, prefer, size_to
from web.build import build
from web.wasm import ROOT, missing_tools

SECONDS = 6.0
"""Into the first run of the page [s]."""


def main() -> None:
    """Run the page's first scenario and save what it looks like."""
    missing = [*missing_tools(), *missing_browser()]
    if missing:
        sys.exit(f"error: picture: needs {', '.join(missing)}")
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "playground.png"
    with tempfile.TemporaryDirectory() as folder, chromium() as driver:
        page = Path(folder, "playground.html")
        build(page)
        size_to(driver, 1280, 800)
        driver.get(page.as_uri())
        prefer(driver, "light")
        time.sleep(1.0)
        driver.execute_script(
            "const { page } = playground; page.again(); page.pace.stop();"
            "while (page.run.seconds < arguments[0]) page.run.advance();",
            SECONDS,
        )
        time.sleep(1.0)
        driver.save_screenshot(str(path))
    print(f"wrote {path}")


if __name__ == "__main__":
    main()
