"""Processor in the loop, run once; what its images have in common is compiled once."""

import hashlib
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import pytest

from benchmarks import bit_identity
from sensorless.design.drive import DriveDesign
from sensorless.export import selftest
from sensorless.export.core_files import FIRMWARE
from sensorless.machine.motor import Motor
from sensorless.pil import pil as loop
from sensorless.pil import tools
from sensorless.pil.pil import Report, pil
from sensorless.table.ks_table import KsTable
from tests.helpers.objects import BUILD, Failed, compiled, flags, is_kept, keep, program_of
from tests.helpers.scenarios import on_the_target


@pytest.fixture(scope="session")
def report(target: None, table: KsTable, motor: Motor, design: DriveDesign) -> Report:
    """A run on the target; the export's own self test has tests of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(selftest, "find_compiler", lambda: None)
        patch.setattr(loop, "pil_scenarios", on_the_target(1.4))
        return pil(table, motor, design, policy="trial")


Build = Callable[..., Path]


def same_everywhere(exported: Path) -> list[Path]:
    """Sources of an image that do not depend on what was exported."""
    own = [path for path in FIRMWARE.glob("*.c") if "params.h" not in path.read_text()]
    return [*(exported / "core").glob("*.c"), *own]


@pytest.fixture(scope="session", autouse=True)
def kept_objects(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Build]:
    """``build`` that takes objects of earlier images where the same sources are compiled again."""

    @cache
    def around(exported: Path) -> list[Path]:
        """Objects of what is not the core: numbers, and the loop around it; compiled once."""
        names = ("params.c", "ks_table_data.c", "ks_table_q15.c", "test/faults.c")
        own = [exported / name for name in names]
        own += [FIRMWARE / f"{name}.c" for name in ("pil", "pil_stages", "port_host")]
        include = [f"-I{path}" for path in (exported, exported / "core", exported / "test")]
        place = tmp_path_factory.mktemp("around")
        words = ["cc", *flags(FIRMWARE / "Makefile", "BITS", "WARNINGS"), "-O0", *include]
        words += [f"-I{FIRMWARE}", "-c", *map(str, own)]
        subprocess.run(words, cwd=place, check=True)
        return sorted(place.glob("*.o"))

    def host(exported: Path, folder: Path, level: str, cc: str) -> Path:
        """As the makefile does it; ``test_bad_inputs`` has one that the makefile builds."""
        how = [cc, *flags(FIRMWARE / "Makefile", "BITS", "WARNINGS"), *level.split()]
        core = compiled(exported / "core", how)
        assert not isinstance(core, Failed), core.stderr
        folder.mkdir()
        words = [*how, *map(str, [*around(exported), *core])]
        subprocess.run([*words, "-o", str(folder / "host")], check=True)
        return folder / "host"

    def build(exported: Path, folder: Path, what: str, level: str = "-O2", cc: str = "cc") -> Path:
        if what == "host":
            return host(exported, folder, level, cc)
        headers = [*(exported / "core").glob("*.h"), *FIRMWARE.glob("*.h")]
        sources = same_everywhere(exported)
        digest = hashlib.sha256(f"{level} {program_of(f'{tools.CROSS}gcc')}".encode())
        for path in sorted([*headers, *sources, FIRMWARE / "Makefile"], key=lambda path: path.name):
            digest.update(path.read_bytes())
        store = BUILD / digest.hexdigest()
        wanted = {f"{path.stem}{end}" for path in sources for end in (".o", ".su")}
        known = is_kept(store)
        if known:
            shutil.copytree(store, folder, copy_function=shutil.copyfile, dirs_exist_ok=True)
        image = tools.build(exported, folder, what, level, cc)
        if not known:
            with tempfile.TemporaryDirectory() as made:
                for path in folder.iterdir():
                    if path.name in wanted:
                        shutil.copy(path, made)
                keep(Path(made), store)
        return image

    first: dict[Path, Path] = {}

    def compared(exported: Path, folder: Path, what: str, level: str, cc: str) -> Path:
        """As ``build``, with the loop around the core as it was first compiled, as on the host."""
        if what == "image":
            same = {path.stem for path in same_everywhere(exported)}
            made = first.setdefault(exported, folder).glob("*.o")
            folder.mkdir(exist_ok=True)
            for path in made:
                if path.stem not in same:
                    shutil.copyfile(path, folder / path.name)
        return build(exported, folder, what, level, cc)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(loop, "build", build)
        patch.setattr(bit_identity, "build", compared)
        yield build
