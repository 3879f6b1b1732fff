"""Every `sensorless` command of the documentation runs, page after page, at a small size.

``make docs-test`` runs it. `python studies/...` runs in ``tests/studies``, `make` in ``.ci/run``;
``test_commands.py`` parses both.
"""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from sensorless.machine.motor import Motor
from sensorless.replay.replay import SAMPLE
from tests.helpers.command import run
from tests.helpers.documentation import PAGES, ROOT, shown

SMALLER = {
    "--size": "4",
    "--budget": "1200",
    "--machines": "2",
    "--steps": "1024",
    "--validate-size": "16",
    "--duration": "0.4",
    "--axes": "speed:0:1:4,torque_current:-1.5:1.5:2",
}
"""Value of an option in place of the one shown."""
LEFT_OUT = ("--minutes", "--n-steps", "--batch-size", "--eval-freq", "--load", "--speed")
"""Options that would ask for more than a small run gives, with their values."""
ADDED = {
    "train": "--steps 1024 --n-envs 16 --n-steps 16 --batch-size 128 --n-epochs 1 --warm-up 1 "
    "--validate-size 16",
    "tune": "--budget 1200",
    "tune gains": "--evaluations 11 --size 8",
    "distill": "--rounds 1 --size 4",
    "evaluate": "--size 4",
    "certify": "--size 4",
    "report": "--size 4 --grid 3 --policy eq25",
    "motor check": "--size 2",
    "motor new": "--poles 10 --speed 2149 --power 9000 --current 17.7 --kt 1.6 --kt-kind peak "
    "--between phase --r 0.85 --l-d 4.45e-3 --l-q 6.3e-3 --u-dc 650 --pwm 10000 --size 2",
}
"""Options behind a command, where it does not have them already."""
ELSEWHERE = {
    "pil": "tests/pil",
    "reproduce": "tests/reproduce",
    "demo": "tests/cli",
    "--ray-address": "tests/evaluation/engines",
}
"""Words of commands that have no small size or need a cluster, and the tests that run them."""
SIZES = {"envelope": "9", "falsify": "128"}
"""Least size of a suite or command that cannot do with that of ``SMALLER``."""


def smaller(words: list[str]) -> list[str]:
    """Words of a command at a small size."""
    out, values = [], iter(words)
    for word in values:
        if word in SMALLER:
            next(values)
            out += [word, SMALLER[word]]
        elif word in LEFT_OUT and words[0] == "train":
            next(values)
        else:
            out.append(word)
    command = next((c for c in (" ".join(words[:2]), words[0]) if c in ADDED), "")
    added = ADDED.get(command, "").split()
    for option, value in zip(added[::2], added[1::2], strict=True):
        out += [] if option in out else [option, value]
    out += ["--no-fit"] if words[0] == "export" else []
    for word, size in SIZES.items():
        if word in out:
            out[out.index("--size") + 1] = size
    return [word.replace("docs/", "") for word in out]


def commands() -> list[tuple[str, list[str]]]:
    """Page and words of every whole command, each once, in the order of the pages."""
    seen, out = set(), []
    for page in PAGES:
        for words, whole in shown(page):
            line = tuple(words[1:])
            if whole and words[0].endswith("sensorless") and line not in seen:
                seen.add(line)
                out.append((page.stem, words[1:]))
    return out


def _write_scope(folder: Path) -> None:
    """Write the sample log with columns of other names and a sign turned."""
    heading, *rows = SAMPLE.read_text(encoding="utf-8").splitlines()
    names = heading.split(",")
    place = names.index("i_b")
    cells = [row.split(",") for row in rows]
    for row in cells:
        row[place] = f"{-float(row[place]):.9g}"
    names = [{"i_a": "Ia", "i_b": "Ib", "theta_e": "angle"}.get(name, name) for name in names]
    text = "\n".join(",".join(row) for row in [names, *cells]) + "\n"
    (folder / "scope.csv").write_text(text, encoding="utf-8")
    (folder / "names.toml").write_text('theta_e = "angle"\n', encoding="utf-8")


def _write_map(motor: Motor, path: Path) -> None:
    """Write a flux map of a machine whose q axis saturates a little."""
    i_d, i_q = np.meshgrid(*2 * [np.linspace(-motor.i_max, motor.i_max, 9)])
    psi_d = motor.psi_f + motor.L_d * i_d
    psi_q = motor.L_q * i_q / (1.0 + 0.2 * np.abs(i_q) / motor.i_max)
    rows = np.stack([x.ravel() for x in (i_d, i_q, psi_d, psi_q)], axis=-1)
    np.savetxt(path, rows, delimiter=",", header="i_d,i_q,psi_d,psi_q", comments="")


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with what a reader would have at hand: a motor file, a map, a trained run."""
    folder = tmp_path_factory.mktemp("desk")
    (folder / "results" / "studies" / "gains").mkdir(parents=True)
    (folder / "sensorless" / "replay").mkdir(parents=True)
    text = (ROOT / "sensorless" / "machine" / "motors" / "paper.toml").read_text(encoding="utf-8")
    changed = re.sub(r"(?m)^B = .*", r"\g<0>\nemf_5 = 0.03\nemf_7 = 0.03", text)
    (folder / "harmonics.toml").write_text(changed, encoding="utf-8")
    for line in (
        ["motor", "new", "--name", "mine", "--out", "mine.toml"],
        ["simulate", "--motor", "mine.toml", "--log", "mylog.csv"],
        ["train", "--name", "first"],
    ):
        done = run(*smaller(line), cwd=folder)
        assert done.returncode == 0, done.stderr
    _write_map(Motor.load(folder / "mine.toml"), folder / "map.csv")
    _write_scope(folder)
    shutil.copytree(folder / "runs" / "first", folder / "runs" / "mine")
    return folder


@pytest.mark.parametrize(
    ("page", "words"), commands(), ids=lambda x: " ".join(x)[:70] if isinstance(x, list) else x
)
def test_a_command_runs(page: str, words: list[str], desk: Path) -> None:
    if elsewhere := [ELSEWHERE[word] for word in words if word in ELSEWHERE]:
        assert (ROOT / elsewhere[0]).is_dir()
        return
    if words[0] == "train":
        shutil.rmtree(desk / "runs" / words[words.index("--name") + 1], ignore_errors=True)
    if "--out" in words and (out := words[words.index("--out") + 1]).endswith(".toml"):
        (desk / out).unlink(missing_ok=True)  # a motor file is not replaced
    done = run(*smaller(words), cwd=desk)
    finds = "bring-up" in words and {"--mistake", "--log"} & set(words)  # a mistake is status 1
    assert done.returncode == bool(finds), done.stderr
