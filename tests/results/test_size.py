"""Results stay few enough to be read, and small enough to be cloned."""

from pathlib import Path

ROOT = Path(__file__).parents[2]


def test_results_stay_small() -> None:
    files = [p.read_bytes() for p in (ROOT / "results").rglob("*") if p.is_file()]
    assert sum(len(data) for data in files) <= 1_000_000
    assert sum(data.count(b"\n") for data in files) <= 12_000
