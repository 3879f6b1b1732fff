"""``sensorless replay`` and ``simulate --log`` on the command line."""

import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.errors import UserError

SAMPLE = "sample"


def run(*words: str) -> str:
    done = CliRunner().invoke(app, list(words), catch_exceptions=False, standalone_mode=False)
    assert done.exit_code == 0
    return done.output


def test_a_simulated_log_is_replayed(tmp_path: Path) -> None:
    """Another machine on another rule, with picture and CSV."""
    log, out, plot = (tmp_path / name for name in ("log.csv", "out.csv", "plot.png"))
    common = ["--motor", "ipmsm_2200w", "--policy", "hysteresis", "--set", "carrier=true"]
    common += ["--set", "estimator=smo"]
    run("simulate", *common, "--speed", "0:300", "--duration", "0.1", "--log", str(log))
    said = run("replay", str(log), *common, "--out", str(out), "--plot", str(plot))
    assert all(name in said for name in ("HFI", "SMO", "blend", "EKF", "ipmsm_2200w"))
    rows = np.genfromtxt(out, delimiter=",", names=True)
    assert len(rows) == len(log.read_text().splitlines()) - 1
    assert plot.read_bytes()[:4] == b"\x89PNG"


@pytest.mark.usefixtures("without_ekf")
def test_the_observer_is_called_what_it_is(tmp_path: Path) -> None:
    for words, name in (((), "flux alone"), (("--set", "estimator=flux"), "flux observer")):
        said = run("replay", SAMPLE, *words)
        assert name in said and "SMO" not in said


def test_mistakes(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"out: .* does not exist"):
        run("replay", SAMPLE, "--out", str(tmp_path / "none" / "out.csv"))
    with pytest.raises(UserError, match="policy"):
        run("replay", SAMPLE, "--policy", "nonsense")
    with pytest.raises(UserError, match=r"log: .* does not exist"):
        run("simulate", "--duration", "0.01", "--log", str(tmp_path / "none" / "log.csv"))


def test_json_is_for_programs() -> None:
    said = json.loads(run("replay", SAMPLE, "--json"))
    assert set(said["estimators"]) == {"hfi", "smo", "blend", "ekf"}
    assert said["estimators"]["smo"]["without_rms_deg"] is None, "no number is null"
