"""The folder of ``sensorless demo``: emptied, never taken from another demo."""

from pathlib import Path

import pytest

from sensorless.cli.demo_steps import MARK, fresh_folder
from sensorless.errors import UserError


def test_a_folder_of_an_earlier_demo_is_emptied(tmp_path: Path) -> None:
    """A link to it stays a link; the mark is never missing, so a killed demo can be run again."""
    real, link = tmp_path / "real", tmp_path / "link"
    with fresh_folder(real, "paper"):
        (real / "run" / "a").mkdir(parents=True)
        (real / "fig9.png").touch()
    link.symlink_to(real)
    with fresh_folder(link, "paper"):
        assert [path.name for path in real.iterdir()] == [MARK]
    assert link.is_symlink()


def test_a_folder_is_for_one_demo_at_a_time(tmp_path: Path) -> None:
    with fresh_folder(tmp_path / "a", "paper"):
        (tmp_path / "a" / "results.json").touch()
        with (
            pytest.raises(UserError, match=r"^out: .* is in use by another demo"),
            fresh_folder(tmp_path / "a", "paper"),
        ):
            pass
        assert (tmp_path / "a" / "results.json").is_file()


@pytest.mark.parametrize("name", ["mine", "file", "x" * 300])
def test_what_is_no_folder_of_a_demo_is_refused(name: str, tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").touch()
    (tmp_path / "file").touch()
    with pytest.raises(UserError, match=r"^out: .*; give"), fresh_folder(tmp_path / name, "paper"):
        pass
    assert (tmp_path / "mine" / "thesis.tex").is_file()
