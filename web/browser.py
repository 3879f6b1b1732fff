"""Chromium without a window, for the tests and for the picture of the documentation."""

import importlib.util
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

PROGRAMS = {"chromium": "chromium", "chromedriver": "chromium-driver"}
"""Programs, and their Debian packages."""


def missing_browser() -> list[str]:
    """What has to be installed first."""
    programs = [package for name, package in PROGRAMS.items() if shutil.which(name) is None]
    return programs + ([] if importlib.util.find_spec("selenium") else ["selenium (pip)"])


@contextmanager
def chromium() -> Iterator[Any]:
    """Selenium's driver, with the logs of console and network, for a ``with`` block."""
    from selenium import webdriver

    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or ""
    for word in (
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-dev-shm-usage",
        "--hide-scrollbars",
    ):
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(
        options=options, service=webdriver.ChromeService(shutil.which("chromedriver"))
    )
    try:
        yield driver
    finally:
        driver.quit()


def size_to(driver: Any, width: int, height: int, *, mobile: bool = False) -> None:
    """Give the page a window of this size [CSS pixels]."""
    size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile}
    driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)


def prefer(driver: Any, scheme: str) -> None:
    """Prefer ``light`` or ``dark`` colours."""
    wanted = {"features": [{"name": "prefers-color-scheme", "value": scheme}]}
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", wanted)
