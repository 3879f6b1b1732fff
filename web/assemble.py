"""Puts script, style and data into one HTML file.

Modules become one script: in an order in which each stands after those that it imports, without
their imports and the word ``export``. So no two may define the same name at their top.
"""

import base64
import gzip
import re
from graphlib import TopologicalSorter
from pathlib import Path

WEB = Path(__file__).resolve().parent
IMPORT = re.compile(r'^import \{[^}]*\} from "\./([\w]+\.js)";\n', re.MULTILINE)
DEFINED = re.compile(r"^(?:export )?(?:async )?(?:function|class|const|let) (\w+)", re.MULTILINE)


def script(folder: Path = WEB / "js") -> str:
    """All modules as one.

    Raises
    ------
    ValueError
        Two modules define the same name, or an import is not in one line's form.
    """
    texts = {path.name: path.read_text(encoding="utf-8") for path in sorted(folder.glob("*.js"))}
    order = TopologicalSorter({name: IMPORT.findall(text) for name, text in texts.items()})
    owner: dict[str, str] = {}
    parts = []
    for name in order.static_order():
        for defined in DEFINED.findall(texts[name]):
            if owner.setdefault(defined, name) != name:
                raise ValueError(f"{defined}: in {owner[defined]} and {name}; rename one")
        text = re.sub(r"^export ", "", IMPORT.sub("", texts[name]), flags=re.MULTILINE)
        if re.search(r"^import\b", text, re.MULTILINE):
            raise ValueError(f'{name}: write imports as import {{ name }} from "./file.js";')
        parts.append(f"// {name}\n{text.strip()}\n")
    return "\n".join(parts)


def packed(data: bytes) -> str:
    """Compressed, in base64; the same bytes for the same data."""
    return base64.b64encode(gzip.compress(data, mtime=0)).decode()


def page(wasm: bytes, image: bytes, layout: str) -> str:
    """Return the whole page as HTML."""
    if "</" in layout:
        raise ValueError("layout: '</' would end its element")
    parts = {
        "STYLE": (WEB / "style.css").read_text(encoding="utf-8").strip(),
        "LAYOUT": layout,
        "WASM": packed(wasm),
        "IMAGE": packed(image),
        "SCRIPT": script(),
    }
    text = (WEB / "page.html").read_text(encoding="utf-8")
    return re.sub(r"@([A-Z]+)@", lambda found: parts[found[1]], text)
