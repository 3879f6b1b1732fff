"""Hooks of MkDocs: pages from outside ``docs/``, pages that are made, links between them."""

import os
import posixpath
import re
import sys
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.exceptions import PluginError
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page

ROOT = Path(__file__).parents[2]
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from docs.site import notebooks  # noqa: E402  (the repository is not installed)
from docs.site.pages import MADE  # noqa: E402

FROM_OUTSIDE = {
    "CHANGELOG.md": "changelog.md",
    "CONTRIBUTING.md": "contributing.md",
    "firmware/README.md": "firmware.md",
    "results/reference/README.md": "results/making.md",
    "results/reference/results.md": "results/reference.md",
    "results/reference/flux/results.md": "results/flux.md",
}
"""Page of the repository, and where it stands on the site."""
HOME = {page: place for place, page in FROM_OUTSIDE.items()}
ON_SITE = {
    **FROM_OUTSIDE,
    "README.md": "index.md",
    "docs/site/environment.md": "environment.md",
    **{f"notebooks/{path.name}": place for place, path in notebooks.PAGES.items()},
}
"""File of the repository that a page may link to, and the page that stands for it on the site."""

SHIM = "https://unpkg.com/iframe-worker/shim"
"""Script that the plugin ``offline`` wants from another host; ours stands beside this file."""
OURS = "assets/javascripts/iframe_worker.js"

OTHER_HOST = re.compile(r"<(?:script|img|iframe|link)\b[^>]*\b(?:src|href)=.?https?:[^>]*>")
"""Tag that makes a browser ask another host."""
PLAYGROUND = ROOT / "build" / "playground" / "playground.html"
"""Of ``make playground``; where it has run, the page stands on the site."""
PLAY = "play.html"
OPEN = f'<a class="md-button" href="{PLAY}">Open the playground</a>\n\n'

LINK = re.compile(r"(?<=\])\(([^)\s:]+)\)")
FENCE = re.compile(r"^ *```.*?^ *```", re.DOTALL | re.MULTILINE)
CODE_IN_LIST = re.compile(r"(?<=\n\n) {6}(?=\S)")
NUMBER = re.compile(r"<td>(?=[−+-]?\d(?:[^<]|<br ?/?>){0,40}</td>)")
"""Opens a cell of a table that is a number with what belongs to it."""
WORD = re.compile(r"<td>(?=<code>[^<]*</code></td>)")
"""Opens a cell of a table that is a word of code and nothing else."""
WIDE = ("leaderboard.md", "results/reference.md", "results/flux.md")
"""Pages whose tables take the room of the table of contents."""
LIST_AFTER_TEXT = re.compile(r"^((?![-*] |\d+\. |\s|\||#)\S.*)\n((?:[-*]|1\.) )", re.MULTILINE)


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages that stand elsewhere in the repository and those that are made."""
    for source, place in FROM_OUTSIDE.items():
        files.append(File.generated(config, place, abs_src_path=str(ROOT / source)))
    for place, make in MADE.items():
        files.append(File.generated(config, place, content=make()))
    return files


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Turn links within the repository into links within the site."""
    here = page.file.src_uri
    if here in WIDE:
        page.meta["hide"] = ["toc"]
    if here == "playground.md" and PLAYGROUND.is_file():
        markdown = markdown.replace("## What it shows", f"{OPEN}## What it shows", 1)
    source = HOME.get(here, f"docs/{here}")
    parts, end = [], 0
    for fence in FENCE.finditer(markdown):
        parts += [_prose(markdown[end : fence.start()], here, source), fence.group()]
        end = fence.end()
    return "".join([*parts, _prose(markdown[end:], here, source)])


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Keep numbers of tables on one line, with their interval, and words of code."""
    return WORD.sub('<td class="word">', NUMBER.sub('<td class="number">', html))


def on_post_build(config: MkDocsConfig) -> None:
    """Put our copy of the one script that would come from another host, and the playground."""
    site = Path(config.site_dir)
    if PLAYGROUND.is_file():
        (site / PLAY).write_bytes(PLAYGROUND.read_bytes())
    (site / OURS).write_bytes(Path(__file__).with_name("iframe_worker.js").read_bytes())
    for page in site.rglob("*.html"):
        if page.name == PLAY:
            continue
        ours = os.path.relpath(site / OURS, page.parent).replace(os.sep, "/")
        text = page.read_text(encoding="utf-8").replace(SHIM, ours)
        if found := OTHER_HOST.search(text):
            raise PluginError(f"{page}: {found.group()} comes from another host")
        page.write_text(text, encoding="utf-8", newline="\n")


def _prose(text: str, here: str, source: str) -> str:
    """Links of a stretch without fences; lists and code in them indented as MkDocs wants it."""
    text = LIST_AFTER_TEXT.sub(r"\1\n\n\2", text)
    text = CODE_IN_LIST.sub("  \\g<0>", text)
    return LINK.sub(lambda found: f"({_target(found.group(1), here, source)})", text)


def _target(link: str, here: str, source: str) -> str:
    name, mark, anchor = link.partition("#")
    if not name:
        return link
    path = posixpath.normpath(posixpath.join(posixpath.dirname(source), name))
    place = ON_SITE.get(path, path.removeprefix("docs/"))
    return posixpath.relpath(place, posixpath.dirname(here) or os.curdir) + mark + anchor
