"""Draws a page as the documentation shows it: the playground, or the page that is named.

Usage: python -m web.picture [FILE.png [PAGE.html]], docs/playground.png by default.
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
    """Save what the page looks like: of the playground, its first scenario."""
    path = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs" / "playground.png"
    named = Path(sys.argv[2]) if len(sys.argv) > 2 else None
    missing = [*([] if named else missing_tools()), *missing_browser()]
    if missing:
        sys.exit(f"error: picture: needs {', '.join(missing)}")
    with tempfile.TemporaryDirectory() as folder, chromium() as driver:
        page = named or Path(folder, "playground.html")
        if named is None:
            build(page)
        size_to(driver, 1280, 800)
        driver.get(page.absolute().as_uri())
        prefer(driver, "light")
        time.sleep(1.0)
        if named is None:
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
