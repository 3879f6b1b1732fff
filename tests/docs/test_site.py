"""The site shows every page of the documentation, and its made pages have the recorded figures."""

import re
from pathlib import Path

import markdown  # type: ignore[import-untyped]
import pytest

from docs.site import tables
from docs.site.pages import API, MADE
from sensorless.machine.motor import MOTORS

ROOT = Path(__file__).parents[2]
NAV = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").split("\nnav:\n")[1]
SHOWN = re.findall(r"([\w/-]+\.md)$", NAV, re.MULTILINE)


def test_every_page_stands_in_the_navigation_once() -> None:
    assert len(SHOWN) == len(set(SHOWN))
    assert {page.name for page in (ROOT / "docs").glob("*.md")} <= set(SHOWN)
    assert set(MADE) <= set(SHOWN)


@pytest.mark.parametrize("name", [name for _, _, names in API.values() for name in names])
def test_what_the_api_pages_name_exists(name: str) -> None:
    folder = ROOT / "sensorless" / name.rpartition(".")[0].replace(".", "/")
    module, _, last = name.rpartition(".")
    if last[0].isupper():
        source = ROOT / "sensorless" / f"{module.replace('.', '/')}.py"
        assert re.search(rf"^class {last}\b", source.read_text(encoding="utf-8"), re.MULTILINE)
    else:
        assert (folder / f"{last}.py").is_file()


def test_the_table_of_motors_has_every_shipped_one() -> None:
    page = tables.motors()
    for path in MOTORS.glob("*.toml"):
        assert f"| `{path.stem}` |" in page


@pytest.mark.parametrize("page", sorted((ROOT / "docs").rglob("*.md")), ids=lambda page: page.stem)
def test_no_page_says_a_thing_twice(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    headings = re.findall(r"^#+ .*$", re.sub(r"```.*?```", "", text, flags=re.DOTALL), re.MULTILINE)
    modules = re.findall(r"^::: (.*)$", text, re.MULTILINE)
    assert len(set(headings)) == len(headings)
    assert len(set(modules)) == len(modules)


@pytest.mark.parametrize("page", sorted((ROOT / "docs").rglob("*.md")), ids=lambda page: page.stem)
def test_no_command_runs_into_the_text_around_it(page: Path) -> None:
    """An indented block right after a list, or a list right after one, is text to the site."""
    text = page.read_text(encoding="utf-8")
    html = markdown.markdown(text, extensions=["tables", "pymdownx.superfences", "md_in_html"])
    prose = re.sub(r"<(pre|code).*?</\1>", "", html, flags=re.DOTALL)
    assert not re.search(r"^(<p>)?(sensorless|python|pip|make) [a-z-]+( |$)", prose, re.MULTILINE)
