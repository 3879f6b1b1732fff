"""What the documentation names exists, and its figures are those of the code and the results."""

import ast
import csv
import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import sensorless
from sensorless.envs.reward import RewardWeights
from sensorless.machine.motor import Motor

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

ROOT = Path(__file__).parents[2]
DOCS = sorted((ROOT / "docs").glob("*.md"))
PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *(ROOT / name for name in ("results/reference/README.md", "firmware/README.md")),
    *DOCS,
]
SOURCES = [*ROOT.glob("*/*.*"), *ROOT.glob("*/*/*.*"), *ROOT.glob("*/*/*/*.*")]
NAMES = {path.name for path in SOURCES if ".venv" not in path.parts and "build" not in path.parts}

TOP = ("agents", "baselines", "core", "envs", "observers", "sensorless")
MADE = ("build/", "runs/", "paper/")
"""Where commands of the documentation write."""
EXPORTED = {
    "params.h",
    "params.c",
    "ks_table_data.c",
    "ks_table_q15.c",
    "test/",
    "example/",
    "cmsis/",
}
"""In the folder that an export writes."""
GONE = ("CHANGELOG.md",)
"""Pages that also name what is no more."""

FENCED = re.compile(r"^ *```(\w*)\n(.*?)^ *```", re.DOTALL | re.MULTILINE)
FILE = re.compile(r"[\w.-]*(/[\w.-]+)*\.(py|c|h|mk|ld|toml|json|csv|png|md|j2|ipynb)")
FOLDER = re.compile(r"([\w.-]+/)+")
SOURCE = re.compile(r"[\w-]+\.(py|c|h|mk|ld|j2)")


def prose(page: Path) -> str:
    return FENCED.sub("", page.read_text(encoding="utf-8"))


def blocks(page: Path, language: str) -> list[str]:
    found = FENCED.findall(page.read_text(encoding="utf-8"))
    return [text for name, text in found if name == language]


def slug(heading: str) -> str:
    """Anchor that a Markdown page gets from a heading."""
    return re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")


def links(page: Path) -> Iterator[str]:
    yield from re.findall(r"\]\(([^)\s]+)\)", prose(page))


def named_paths(text: str) -> Iterator[str]:
    """Words of spans that look like a file or folder of the repository."""
    for span in re.findall(r"`([^`]+)`", text):
        for word in span.split():
            if FILE.fullmatch(word) and ("/" in word or SOURCE.fullmatch(word)):
                yield word
            elif FOLDER.fullmatch(word):
                yield word


def exists(word: str, page: Path) -> bool:
    if word.startswith(MADE) or word in EXPORTED or "NAME" in word:
        return True
    if "/" not in word:
        return word in NAMES
    return (ROOT / word).exists() or (page.parent / word).exists()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_link_leads_somewhere(page: Path) -> None:
    for target in links(page):
        if re.match(r"https?://", target):
            continue
        name, _, anchor = target.partition("#")
        to = (page.parent / name).resolve() if name else page
        assert to.exists(), target
        headings = re.findall(r"^#+ (.*)$", prose(to), re.MULTILINE) if anchor else []
        assert not anchor or anchor in map(slug, headings), target


@pytest.mark.parametrize("page", [p for p in PAGES if p.name not in GONE], ids=lambda p: p.stem)
def test_every_file_that_is_named_exists(page: Path) -> None:
    missing = [word for word in named_paths(prose(page)) if not exists(word, page)]
    assert not missing, "named on the page, but nowhere in the repository"


def test_what_is_missing_is_found() -> None:
    page = ROOT / "docs" / "results.md"
    for word in ("envs/gone.py", "gone.h", "core/gone/", "results/gone.json"):
        assert [word] == [w for w in named_paths(f"see `{word}`") if not exists(w, page)]
    assert slug("Two commands, `k_s`") == "two-commands-k_s"


def test_every_page_is_reached_from_the_readme() -> None:
    reached, left = set[Path](), [ROOT / "README.md"]
    while left:
        page = left.pop()
        found = {(page.parent / target.partition("#")[0]).resolve() for target in links(page)}
        left += [to for to in found - reached if to in DOCS]
        reached |= found
    assert not set(DOCS) - reached


def test_no_picture_is_shown_twice_or_not_at_all() -> None:
    pages = [page for page in PAGES if page.name != "index.md"]  # the README's counterpart
    drawn = [
        (p, t) for p in pages for t in re.findall(r"!\[[^\]]*\]\(([^)]+\.png)\)", p.read_text())
    ]
    shown = [(page.parent / name).resolve() for page, name in drawn]
    assert sorted(shown) == sorted((ROOT / "docs").glob("*.png"))


@pytest.mark.parametrize("page", [p for p in PAGES if blocks(p, "python")], ids=lambda p: p.stem)
def test_the_loop_of_a_page_runs(page: Path) -> None:
    (loop,) = blocks(page, "python")
    seen: dict[str, object] = {}
    exec(loop.replace("range(1000)", "range(10)"), seen)
    assert getattr(seen["obs"], "shape", None) == (64, 12)


def test_the_motor_file_of_the_documentation_loads() -> None:
    (text,) = blocks(ROOT / "docs" / "motor-file.md", "toml")
    assert Motor.from_tables(tomllib.loads(text), "motor-file.md").name == "mine"


def rows(text: str) -> list[list[str]]:
    """Cells of the rows of Markdown tables."""
    return [line.strip("| ").split(" | ") for line in text.splitlines() if line.startswith("| ")]


FIGURES = {
    "torque deviation [%]": ("torque_dev_rms", 100.0),
    "torque ripple [%]": ("torque_ripple_rms", 100.0),
    "overshoot beyond the twin's [%]": ("overshoot_excess_pct", 1.0),
    "angle error [°]": ("angle_err_rms_deg", 1.0),
}
"""Heading: column of the leaderboard, and factor."""


def figure(row: dict[str, str], heading: str) -> str:
    """Mean ± half its interval."""
    name, factor = FIGURES[heading]
    mean, low, high = (factor * float(row[f"{name}{end}"]) for end in ("", "_low", "_high"))
    return f"{mean:.2f} ± {(high - low) / 2.0:.2f}"


@pytest.mark.parametrize(("name_of", "count"), [("README.md", 5), ("docs/index.md", 5)])
def test_the_first_table_is_that_of_the_leaderboard(name_of: str, count: int) -> None:
    """Same suite, seed and size: update both pages when studies/leaderboard.py has run anew."""
    with (ROOT / "results" / "leaderboard.csv").open(encoding="utf-8") as file:
        known = {row["policy"]: row for row in csv.DictReader(file) if row["suite"] == "stress-1"}
    size = int(known["eq25"]["feasible"])
    mine = next(part for part in prose(ROOT / name_of).split("\n## ") if "| lost, of" in part)
    top, *lines = rows(mine.replace("| | lost", "| policy | lost"))
    assert top[1] == f"lost, of {size}"
    assert len(lines) == count
    for label, lost, *figures in lines:
        (name,) = re.findall(r"`(.+)`", label)
        assert int(lost) == int(known[name]["lost"])
        assert figures == [figure(known[name], heading) for heading in top[2:]]
    if name_of != "README.md":
        return
    paper, default, *others = (
        figure(known[name], "torque deviation [%]").split()[0]
        for name in ("sliding_mode", "eq25", "reference", "fuzzy-coupled-tuned")
    )
    page = " ".join(prose(ROOT / name_of).split())
    worst = f"loses {known['sliding_mode']['lost']} of {size} random scenarios; its torque deviates"
    assert f"{worst} by {paper} %" in page
    assert known["eq25"]["lost"] == "0"
    assert f"loses 0 of {size} and deviates by {default} %" in page
    shares = sorted({f"{100 * (1 - float(x) / float(default)):.0f}" for x in others}, key=int)
    assert f"takes {' to '.join(shares)} % off that" in page


def test_the_reward_is_that_of_the_environment() -> None:
    table = {line[0]: line[1] for line in rows(prose(ROOT / "docs" / "how-it-learns.md"))}
    weights = vars(RewardWeights()).copy()
    assert float(table.pop("lost_penalty").split(",")[0]) == weights.pop("lost")
    assert {name: float(table[name]) for name in weights} == weights


def test_the_layers_are_those_of_the_test() -> None:
    tree = ast.parse((ROOT / "tests" / "test_layers.py").read_text(encoding="utf-8"))
    (layers,) = (
        ast.literal_eval(node.value)
        for node in tree.body
        if isinstance(node, ast.Assign) and ast.unparse(node.targets[0]) == "LAYERS"
    )
    page = prose(ROOT / "docs" / "layout.md")
    told = re.findall(r"^\d+\. (.*)$", page, re.MULTILINE)
    listed = [tuple(re.findall(r"`(\w+)`", line)) for line in told]
    assert listed == list(layers), "list the layers of tests/test_layers.py in docs/layout.md"


def test_the_tree_has_every_folder() -> None:
    (tree,) = blocks(ROOT / "docs" / "layout.md", "")
    told, above = set(), [ROOT]
    for indent, name in re.findall(r"^( *)([\w-]+)/ ", tree, re.MULTILINE):
        above = [*above[: 1 + len(indent) // 2], above[len(indent) // 2] / name]
        told.add(above[-1])
    assert all(folder.is_dir() for folder in told)
    packages = {init.parent for name in TOP for init in (ROOT / name).glob("*/__init__.py")}
    links = {path for path in packages if path.is_symlink()}
    assert packages - links <= told, "add a line to the tree of docs/layout.md"


def test_the_list_of_the_firmware_has_every_file() -> None:
    page = (ROOT / "firmware" / "README.md").read_text(encoding="utf-8")
    files = {path.name for path in (ROOT / "firmware").iterdir()} - {"README.md"}
    missing = {n for n in files if f"`{n}`" not in page and f"`{n}/`" not in page}
    assert not missing, "list them in firmware/README.md"


def test_citation_and_project_have_the_version_of_the_package() -> None:
    version = [sensorless.__version__]
    assert re.findall(r'^version = "(.+)"$', (ROOT / "pyproject.toml").read_text(), re.M) == version
    assert re.findall(r"^version: (.+)$", (ROOT / "CITATION.cff").read_text(), re.M) == version
