"""The page in a browser, which starts once."""

import importlib.util
import os
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from web.build import build
from web.wasm import missing_tools

PROGRAMS = {"chromium": "chromium", "chromedriver": "chromium-driver"}
"""Programs, and their Debian packages."""


@dataclass(frozen=True)
class Shown:
    """The page in Chromium."""

    driver: Any
    file: Path
    size: int

    def run(self, script: str, *arguments: object) -> Any:
        """Value that a script in the page returns."""
        return self.driver.execute_script(script, *arguments)

    def size_to(self, width: int, height: int, *, mobile: bool = False) -> None:
        """Give the page a window of this size [CSS pixels]."""
        size = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": mobile}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)

    def scheme(self, name: str) -> None:
        """Prefer ``light`` or ``dark`` colours."""
        wanted = {"features": [{"name": "prefers-color-scheme", "value": name}]}
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", wanted)


def _missing() -> list[str]:
    programs = [package for name, package in PROGRAMS.items() if shutil.which(name) is None]
    selenium = [] if importlib.util.find_spec("selenium") else ["selenium (pip)"]
    return [*missing_tools(), *programs, *selenium]


@pytest.fixture(scope="session")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shown]:
    """The page, built and loaded; required where the environment says CI=true."""
    missing = _missing()
    if missing and os.environ.get("CI") == "true":
        pytest.fail(f"CI needs {', '.join(missing)}")
    if missing:
        pytest.skip(f"needs {', '.join(missing)}")
    from selenium import webdriver

    file = tmp_path_factory.mktemp("playground") / "playground.html"
    size = build(file)
    options = webdriver.ChromeOptions()
    options.binary_location = shutil.which("chromium") or ""
    for word in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage"):
        options.add_argument(word)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    service = webdriver.ChromeService(shutil.which("chromedriver"))
    driver = webdriver.Chrome(options=options, service=service)
    try:
        driver.get(file.as_uri())
        yield Shown(driver, file, size)
    finally:
        driver.quit()
