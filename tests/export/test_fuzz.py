"""libFuzzer with sanitizers over table check, schedule and control step, always the same runs."""

import subprocess
from pathlib import Path

from sensorless.export.export import Exported
from tests.export.conftest import SANITIZERS
from tests.helpers.objects import flags

RUNS = 12_000
"""With long inputs from the start they find 98 % of the features that twice as many do."""


def test_nothing_is_found(exported: Exported, watched: list[Path], tmp_path: Path) -> None:
    folder = exported.folder
    sources = [Path(__file__).with_name("fuzz.c"), *folder.glob("*.c")]
    program = tmp_path / "fuzz"
    how = ["clang", *flags(folder / "Makefile", "FLAGS"), *SANITIZERS, "-O0", "-fsanitize=fuzzer"]
    files = map(str, [*sources, *watched])
    subprocess.run([*how, f"-I{folder}", *files, "-o", str(program)], check=True)
    (tmp_path / "corpus").mkdir()
    options = [f"-runs={RUNS}", "-len_control=0", "-max_len=600", "-seed=1", "-rss_limit_mb=1024"]
    done = subprocess.run(
        [str(program), *options, str(tmp_path / "corpus")],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert f"Done {RUNS} runs" in done.stderr
