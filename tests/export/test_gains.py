"""An export whose schedule also sets gains."""

import shutil
import subprocess
from pathlib import Path

import pytest

from sensorless.export.core_files import core_files
from sensorless.export.export import Exported


def test_the_self_test_covers_gains(with_gains: Exported) -> None:
    assert with_gains.self_test.ran
    text = (with_gains.folder / "ks_table_data.h").read_text()
    assert "#define KS_TABLE_GAINS 2 " in text and "gain_vectors_q15" in text
    assert (
        ".gain = {GAIN_OBSERVER, GAIN_AMPLITUDE}"
        in (with_gains.folder / "ks_table_data.c").read_text()
    )


def test_a_damaged_value_fails_the_self_test(with_gains: Exported, tmp_path: Path) -> None:
    from sensorless.errors import UserError
    from sensorless.export.selftest import run_selftest

    copy = shutil.copytree(with_gains.folder, tmp_path / "copy")
    data = copy / "ks_table_q15.c"
    text = data.read_text()
    assert text.count("16384") >= 1  # 0.5 of the observer's grid
    data.write_text(text.replace("16384", "16385"))
    with pytest.raises(UserError, match="Q15 gains: check: wrong CRC"):
        run_selftest(copy)


def test_the_readme_calls_the_schedule_with_gains(with_gains: Exported) -> None:
    text = (with_gains.folder / "README.md").read_text()
    assert "gain_schedule_init(&gain_schedule_params, &schedule, &drive_params, &live)" in text
    assert "drive_step(&live, &drive, &in)" in text
    assert "| amplitude | 0.5 | 1 | 10 |" in text


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
def test_the_bare_example_sets_gains(with_gains: Exported, exported: Exported) -> None:
    """On the folder at hand: one with gains steps them and gives them to the drive."""
    for made, gains in ((with_gains, True), (exported, False)):
        source = made.folder / "example" / "cortex_m4.c"
        words = ["gcc", "-std=c99", "-Wall", "-Werror", "-Wno-int-to-pointer-cast"]
        subprocess.run([*words, "-fsyntax-only", source], check=True)
        seen = subprocess.run([*words, "-E", source], check=True, capture_output=True, text=True)
        body = seen.stdout.rpartition("adc_interrupt(void);")[0]
        assert ("return drive_step(&live, &drive, &in)" in body) == gains
        assert ("return drive_step(&drive_params, &drive, &in)" in body) != gains


def test_what_sets_gains_ships_only_with_gains(with_gains: Exported, exported: Exported) -> None:
    alone = {path.name for path in (exported.folder / "core").iterdir()}
    assert not any(name.startswith("gain") for name in alone)
    found = {path.name for path in (with_gains.folder / "core").iterdir()}
    assert found == set(core_files(gains=True)) and found > alone
    assert "ks_schedule_init(&schedule_params" in (exported.folder / "README.md").read_text()


def test_the_readme_tells_two_motors_of_gains(with_gains: Exported, exported: Exported) -> None:
    """Of two folders, one with gains has more of a core, and the same of the rest."""
    for made, kind in ((with_gains, "gain_schedule"), (exported, "ks_schedule")):
        said = (made.folder / "README.md").read_text(encoding="utf-8")
        params = (made.folder / "params.h").read_text(encoding="utf-8")
        name = f"{kind.removeprefix('ks_')}_params"
        declared = f"extern const {kind}_params_t {name};"
        assert declared in params
        left = declared.replace(f" {name};", f" left_{name};")
        assert f"    {left}   /* with core/{kind}.h */" in said
        assert "no file differs" in said and "more files, `gain*`" in said
    more, less = (
        {path.name: path.read_bytes() for path in (made.folder / "core").iterdir()}
        for made in (with_gains, exported)
    )
    assert less.items() < more.items()
    assert all(name.startswith("gain") for name in more.keys() - less.keys())


Q15 = """
#include "ks_hook_params.h"
#include "params.h"

int main(void) {
    ks_schedule_state_t x;
    ks_hook_state_t hook;
    int bad = schedule_params.table->value_format != KS_VALUES_Q15;
    bad |= ks_hook_params.schedule.table->value_format != KS_VALUES_Q15;
#if KS_TABLE_GAINS
    gain_schedule_state_t gains;
    drive_params_t live;
    bad |= gain_schedule_params.ks.table->value_format != KS_VALUES_Q15;
    bad |= gain_schedule_init(&gain_schedule_params, &gains, &drive_params, &live) != KS_OK;
    bad |= gains.ks.fault != 0;
#endif
    bad |= ks_schedule_init(&schedule_params, &x) != KS_OK;
    return bad | (ks_hook_init(&ks_hook_params, &hook) != KS_OK);
}
"""


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
def test_a_flag_takes_the_schedule_in_16_bits(
    with_gains: Exported, exported: Exported, tmp_path: Path
) -> None:
    """Instead of that in float32, and without an edit of a file."""
    (tmp_path / "main.c").write_text(Q15)
    for made in (with_gains, exported):
        folder = made.folder
        files = [tmp_path / "main.c", *(folder / "core").glob("*.c"), folder / "params.c"]
        files += [folder / "ks_hook_params.c", folder / "ks_table_q15.c"]
        words = ["gcc", "-std=c99", "-Wall", "-Wextra", "-Wundef", "-Werror", "-DKS_USE_Q15"]
        program = tmp_path / "q15"
        subprocess.run([*words, f"-I{folder}", *files, "-lm", "-o", program], check=True)
        subprocess.run([program], check=True)
        assert "-DKS_USE_Q15" in (folder / "README.md").read_text(encoding="utf-8")
        test = folder / "test" / "selftest.c"
        refused = subprocess.run(
            ["gcc", "-DKS_USE_Q15", "-fsyntax-only", test],
            capture_output=True,
            text=True,
            check=False,
        )
        assert refused.returncode != 0 and "without KS_USE_Q15" in refused.stderr
