"""Modules become one script only if that means the same."""

from pathlib import Path

import pytest

from web.assemble import page, script


def written(folder: Path, **texts: str) -> Path:
    for name, text in texts.items():
        (folder / f"{name}.js").write_text(text, encoding="utf-8")
    return folder


def test_a_module_stands_after_those_it_imports(tmp_path: Path) -> None:
    first = 'import { b } from "./second.js";\nexport const a = b + 1;\n'
    made = script(written(tmp_path, first=first, second="export const b = 1;\n"))
    assert made == "// second.js\nconst b = 1;\n\n// first.js\nconst a = b + 1;\n"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("const b = 2;\n", "b: in"),
        ('import * as all from "./second.js";\n', "write imports"),
        ('import b from "./second.js";\n', "write imports"),
    ],
    ids=["the same name twice", "a name for all", "a default"],
)
def test_what_would_change_is_refused(tmp_path: Path, text: str, message: str) -> None:
    folder = written(tmp_path, first=text, second="export const b = 1;\n")
    with pytest.raises(ValueError, match=message):
        script(folder)


def test_data_cannot_end_its_element() -> None:
    with pytest.raises(ValueError, match="layout"):
        page(b"", b"", '{"text": "</script>"}')


def test_script_asks_for_nothing_else() -> None:
    """No address, and nothing that loads one."""
    made = script().replace("http://www.w3.org/2000/svg", "")
    for word in ("http", "fetch(", "XMLHttpRequest", "import(", "WebSocket"):
        assert word not in made
