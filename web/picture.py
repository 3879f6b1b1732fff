"""Draws a page as the documentation shows it: the playground, or the page that is named.

Usage: python -m web.picture [FILE.png [PAGE.html]], docs/playground.png by default.
"""

import argparse
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
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    picture = ROOT / "docs" / "playground.png"
    parser.add_argument("picture", type=Path, nargs="?", default=picture)
    parser.add_argument("page", type=Path, nargs="?", help="of this page, not of the playground")
    words = parser.parse_args()
    path, named = words.picture, words.page
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
