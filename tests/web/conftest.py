"""The page in a browser, which starts once."""

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from web.browser import chromium, missing_browser
from web.build import build
from web.wasm import missing_tools


@dataclass(frozen=True)
class Shown:
    """The page in Chromium."""

    driver: Any
    file: Path
    size: int

    def run(self, script: str, *arguments: object) -> Any:
        """Value that a script in the page returns."""
        return self.driver.execute_script(script, *arguments)


@pytest.fixture(scope="session")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Shown]:
    """The page, built and loaded; required where the environment says CI=true."""
    missing = [*missing_tools(), *missing_browser()]
    if missing and os.environ.get("CI") == "true":
        pytest.fail(f"CI needs {', '.join(missing)}")
    if missing:
        pytest.skip(f"needs {', '.join(missing)}")
    file = tmp_path_factory.mktemp("playground") / "playground.html"
    size = build(file)
    with chromium() as driver:
        driver.get(file.as_uri())
        yield Shown(driver, file, size)
