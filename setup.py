"""What pyproject.toml cannot hold: the C core, built by cffi, and a check of the links."""

import sys
from pathlib import Path

from setuptools import setup

LINKS = ("agents", "baselines", "core", "envs", "firmware", "observers", "reference")

for name in LINKS:
    if not (Path(__file__).parent / "sensorless" / name).is_dir():
        sys.exit(
            f"error: sensorless/{name} is not a link to a folder: this checkout has no symbolic "
            "links. Clone again with: git clone -c core.symlinks=true"
        )

setup(cffi_modules=["core/binding.py:ffibuilder"])
