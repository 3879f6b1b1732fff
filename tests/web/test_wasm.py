"""The core as WebAssembly is compiled once, also where two processes begin together."""

import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Barrier
from typing import Any

import pytest

from web import wasm


def test_two_that_compile_at_once_both_have_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    together = Barrier(2, timeout=30.0)

    def compiler(words: list[str], **_: Any) -> "subprocess.CompletedProcess[str]":
        Path(words[words.index("-o") + 1]).write_bytes(b"module")
        together.wait()
        return subprocess.CompletedProcess(words, 0, "", "")

    monkeypatch.setattr(wasm, "BUILD", tmp_path)
    monkeypatch.setattr(wasm, "missing_tools", list)
    monkeypatch.setattr(subprocess, "run", compiler)
    with ThreadPoolExecutor(2) as pool:
        made = [pool.submit(wasm.compile_core) for _ in range(2)]
        assert [one.result(60.0) for one in made] == [b"module"] * 2
    assert [path.suffix for path in tmp_path.iterdir()] == [".wasm"]
