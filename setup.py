"""What pyproject.toml cannot hold: the C core, the wheel's tag, and a check of the links."""

import os
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from setuptools import setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_ext import build_ext

LINKS = ("agents", "baselines", "core", "envs", "firmware", "observers", "reference")

for name in LINKS:
    if not (Path(__file__).parent / "sensorless" / name).is_dir():
        sys.exit(
            f"error: sensorless/{name} is not a link to a folder: this checkout has no symbolic "
            "links. Clone again with: git clone -c core.symlinks=true"
        )

OLDEST = "cp310"
"""As in requires-python."""


class Build(build_ext):  # type: ignore[misc]
    """Compiles the files of the core side by side, where setuptools takes one after the other."""

    def build_extensions(self) -> None:
        """One compiler for each processor; the first error ends the build."""
        one_after_another = self.compiler.compile

        def side_by_side(sources: list[str], **options: object) -> list[str]:
            with ThreadPoolExecutor(os.cpu_count()) as pool:
                objects = pool.map(lambda path: one_after_another([path], **options), sources)
                return [path for each in objects for path in each]

        self.compiler.compile = side_by_side
        super().build_extensions()


class Wheel(bdist_wheel):  # type: ignore[misc]
    """Tagged abi3 where cffi builds the core for every later Python, which it does on CPython."""

    def finalize_options(self) -> None:
        """Read what cffi decided."""
        if all(extension.py_limited_api for extension in self.distribution.ext_modules):
            self.py_limited_api = OLDEST
        super().finalize_options()


setup(
    cffi_modules=["core/binding.py:ffibuilder"], cmdclass={"bdist_wheel": Wheel, "build_ext": Build}
)
