"""Checks pages in Chromium: console, requests, names of controls, contrast, width, first paint.

Usage: python -m web.audit FILE...
"""

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any

from web.browser import chromium, missing_browser, prefer, size_to

CHECKS = (Path(__file__).parent / "checks.js").read_text(encoding="utf-8")
CONTRAST = 4.5
"""Least one of text, WCAG AA."""
PAINT = 2000.0
"""Latest first paint [ms]."""
WIDE, PHONE = (1280, 800), (390, 844)
PAINTED = """
    const look = () => {
      const [paint] = performance.getEntriesByName("first-contentful-paint");
      paint ? arguments[0](paint.startTime) : requestAnimationFrame(look);
    };
    look();
"""
"""Waits for the first paint; gives its time [ms]."""


def audit(driver: Any, file: Path, most: int | None = None, root: Path | None = None) -> list[str]:
    """Open a page; return what is wrong with it.

    Parameters
    ----------
    driver
        Of ``browser.chromium``; the page stays open in it.
    file : Path
    most : int, optional
        Largest size of the file [bytes]; a page that has one stands alone.
    root : Path, optional
        Folder that any other page may ask for; by default its own.
    """
    for log in ("browser", "performance"):
        driver.get_log(log)
    prefer(driver, "light")
    size_to(driver, *WIDE)
    driver.get(file.resolve().as_uri())
    found = []
    paint = driver.execute_async_script(PAINTED)
    for _ in range(2):  # another program may have had the processor
        if paint > PAINT:
            driver.refresh()
            paint = min(paint, driver.execute_async_script(PAINTED))
    if paint > PAINT:
        found.append(f"first paint after {paint:.0f} ms")
    if most is not None and file.stat().st_size > most:
        found.append(f"{file.stat().st_size} bytes")
    for scheme in ("light", "dark"):
        prefer(driver, scheme)
        driver.execute_script("localStorage.clear()")  # where a site keeps the scheme of last time
        driver.refresh()
        found += [
            f"{scheme}: {x}" for x in driver.execute_script(f"{CHECKS}return faint({CONTRAST})")
        ]
    found += [f"no name: {x}" for x in driver.execute_script(CHECKS + "return unnamed()")]
    size_to(driver, *PHONE, mobile=True)
    width = driver.execute_script("return document.documentElement.scrollWidth")
    if width > PHONE[0]:
        found.append(f"{width} dots wide on a phone of {PHONE[0]}")
    prefer(driver, "light")
    size_to(driver, *WIDE)
    found += [
        f"console: {e['message']}" for e in driver.get_log("browser") if e["level"] != "DEBUG"
    ]
    own = file if most is not None else root or file.parent
    return found + [f"asks for {x}" for x in _requests(driver, own.resolve().as_uri())]


def _requests(driver: Any, own: str) -> list[str]:
    """Addresses asked for that do not begin with ``own``."""
    told = [json.loads(entry["message"])["message"] for entry in driver.get_log("performance")]
    asked = [
        m["params"]["request"]["url"] for m in told if m["method"] == "Network.requestWillBeSent"
    ]
    return [url for url in asked if not url.startswith((own, "data:", "blob:"))]


def main() -> None:
    """Check the files of the command line; status 1 if something is wrong."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n")[0])
    parser.add_argument("page", type=Path, nargs="+", help="HTML files")
    files = parser.parse_args().page
    missing = missing_browser()
    if missing:
        sys.exit(f"error: install {', '.join(missing)}")
    if not all(file.is_file() for file in files):
        sys.exit(f"error: {', '.join(map(str, files))}: give pages that exist")
    with chromium() as driver:
        root = Path(os.path.commonpath([file.resolve().parent for file in files]))
        found = [f"{file}: {x}" for file in files for x in audit(driver, file, root=root)]
    print("\n".join(found) or "nothing found")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
