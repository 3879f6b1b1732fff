"""Every cell of the notebooks runs, at a small size: ``make docs-test``."""

from pathlib import Path

import pytest

from docs.site.notebooks import PAGES, cells, markdown


@pytest.mark.parametrize("path", PAGES.values(), ids=lambda path: path.stem)
def test_a_notebook_runs(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SCENARIOS", "4")
    monkeypatch.setenv("STEPS", "1024")
    page = markdown(path)
    assert page.count("```python") == sum(is_code for is_code, _ in cells(path))
    assert "self test passed" in page
    assert page.count("data:image/png") == 2
