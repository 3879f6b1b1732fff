"""Every requirement has a lowest version that can be tested."""

from tests.helpers.script import ROOT, script


def test_every_requirement_has_a_lowest_version() -> None:
    found = list(script("studies/lowest_versions.py").lowest(ROOT / "pyproject.toml"))
    assert len(found) > 15 and all("==" in word for word in found)
    assert "numpy==1.26.*" in found


def test_the_tested_versions_are_locked() -> None:
    locked = (ROOT / "constraints.txt").read_text(encoding="utf-8")
    lines = [line for line in locked.splitlines() if not line.startswith("#")]
    assert lines == sorted(lines), "as make lock writes it"
    for word in script("studies/lowest_versions.py").lowest(ROOT / "pyproject.toml"):
        assert f"\n{word.split('==')[0]}==" in locked
