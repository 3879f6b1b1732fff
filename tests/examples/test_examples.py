"""Every example runs, at a small size, and says what it promises."""

from pathlib import Path

import pytest

from tests.helpers.script import ROOT, script

EXAMPLES = ROOT / "examples"
SCREEN = 80
"""Most lines of an example: one screen."""
RUNS = {
    "own_rule": (["--size", "4"], "more-under-load"),
    "own_motor": (["--size", "2", "--out", "hub.toml"], "suits this drive: yes"),
    "evaluate_from_python": (["--size", "4"], "under reference: kept lock"),
    "replay_a_log": (["--after", "0.5"], "estimator=smo"),
    "flash": (["--out", "firmware"], "self test"),
}
"""Small arguments and words of the output by example."""


@pytest.mark.parametrize("name", RUNS)
def test_an_example_runs(
    name: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    words, promised = RUNS[name]
    script(f"examples/{name}.py").main(words)
    assert promised in capsys.readouterr().out


@pytest.mark.parametrize("path", sorted(EXAMPLES.glob("*.py")), ids=lambda path: path.stem)
def test_an_example_fits_on_a_screen(path: Path) -> None:
    assert len(path.read_text(encoding="utf-8").splitlines()) <= SCREEN
