"""Two exports in one program, as the README of an export says."""

import shutil
import subprocess
from pathlib import Path

import pytest

from sensorless.export.export import Exported

PROGRAM = """
#include "core/drive.h"
#include "core/ks_schedule.h"

extern const drive_params_t left_drive_params, right_drive_params;
extern const ks_schedule_params_t left_schedule_params, right_schedule_params;

static int runs(const drive_params_t *p, const ks_schedule_params_t *q) {
    drive_state_t x;
    ks_schedule_state_t y;
    drive_in_t in = {0.0f, 0.0f, 540.0f, 0.0f, 0.0f};
    drive_init(p, &x, 0.0f, 0.0f, 1.0f);
    ks_schedule_init(q, &y);
    in.k_s_ref = ks_schedule_step(q, &y, &p->signal, &x.signal);
    drive_step(p, &x, &in);
    return x.fault == 0 && y.fault == 0;
}

int main(void) {
    return !(runs(&left_drive_params, &left_schedule_params) &&
             runs(&right_drive_params, &right_schedule_params));
}
"""


@pytest.mark.skipif(not all(map(shutil.which, ("gcc", "objcopy"))), reason="needs gcc, objcopy")
def test_prefixes_keep_two_exports_apart(exported: Exported, tmp_path: Path) -> None:
    folder = exported.folder
    compiled = ["gcc", "-std=c99", "-O2", f"-I{folder}"]
    objects = []
    for side in ("left", "right"):
        for name in ("params", "ks_table_data"):
            out = tmp_path / f"{side}_{name}.o"
            subprocess.run([*compiled, "-c", str(folder / f"{name}.c"), "-o", str(out)], check=True)
            prefix = f"--prefix-symbols={side}_"
            assert f"objcopy {prefix} {name}.o" in _said(folder).replace("left_", f"{side}_")
            subprocess.run(["objcopy", prefix, str(out)], check=True)
            objects.append(out)
    (tmp_path / "main.c").write_text(PROGRAM)
    files = [tmp_path / "main.c", *folder.glob("core/*.c"), *objects]
    subprocess.run([*compiled, *map(str, files), "-lm", "-o", str(tmp_path / "two")], check=True)
    subprocess.run([tmp_path / "two"], check=True)


def _said(folder: Path) -> str:
    return (folder / "README.md").read_text()
