"""Pages in a browser, which starts once."""

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
    """The playground in Chromium."""

    driver: Any
    file: Path
    size: int

    def run(self, script: str, *arguments: object) -> Any:
        """Value that a script in the page returns."""
        return self.driver.execute_script(script, *arguments)


@pytest.fixture(scope="session")
def driver() -> Iterator[Any]:
    """Chromium, started once; required where the environment says CI=true."""
    require(missing_browser())
    with chromium() as started:
        yield started


@pytest.fixture(scope="session")
def shown(driver: Any, tmp_path_factory: pytest.TempPathFactory) -> Shown:
    """The page, built and loaded."""
    require(missing_tools())
    file = tmp_path_factory.mktemp("playground") / "playground.html"
    size = build(file)
    driver.get(file.as_uri())
    return Shown(driver, file, size)


def require(missing: list[str]) -> None:
    """Skip, or fail where the environment says CI=true, if something is missing."""
    if missing and os.environ.get("CI") == "true":
        pytest.fail(f"CI needs {', '.join(missing)}")
    if missing:
        pytest.skip(f"needs {', '.join(missing)}")
