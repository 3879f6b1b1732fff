"""``results/`` stays small: records and tables, no logs, no page that a command makes."""

from pathlib import Path

ROOT = Path(__file__).parents[2]
LINES, BYTES = 12_000, 1_000_000


def test_results_are_small() -> None:
    """All files together, as ``wc`` counts them."""
    folder = ROOT / "results"
    contents = [path.read_bytes() for path in folder.rglob("*") if path.is_file()]
    assert len(contents) > 50
    assert sum(map(len, contents)) < BYTES
    assert sum(raw.count(b"\n") for raw in contents) <= LINES
