"""The one setting that pyproject.toml cannot hold: the C core, built by cffi."""

from setuptools import setup

setup(cffi_modules=["core/binding.py:ffibuilder"])
