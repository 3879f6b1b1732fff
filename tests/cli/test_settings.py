"""``sensorless settings``: every name of --set, as the design declares it."""

import json
import math
from dataclasses import asdict

import pytest
from typer.testing import CliRunner

from sensorless.cli.app import app
from sensorless.design.derived import derive
from sensorless.design.drive import DriveDesign
from sensorless.design.words import design_from
from sensorless.errors import UserError
from sensorless.machine.motor import Motor
from sensorless.settings import AUTO, settings_of

RUNNER = CliRunner()


def test_every_setting_is_listed() -> None:
    """On a line of its own, with its meaning and its choices."""
    done = RUNNER.invoke(app, ["settings"])
    assert done.exit_code == 0
    lines, said = done.output.splitlines(), done.output.split()
    for s in settings_of(DriveDesign).values():
        assert len([line for line in lines if line.split()[:1] == [s.name]]) == 1
        assert set(s.meaning.split()) <= set(said)
        assert set(s.choices) <= {word.strip(",:") for word in said}


def test_json_tells_what_a_design_is_made_of() -> None:
    """Defaults are those of the class, and --set takes each of them back."""
    facts = json.loads(RUNNER.invoke(app, ["settings", "--json"]).output)
    design = {f["name"]: f["default"] for f in facts}
    want = asdict(DriveDesign())
    automatic = {name: AUTO for name, value in want.items() if value is None}
    assert design == {**want, **automatic, "smo_emf_hz": "inf"} and "speed_hz" in automatic
    assert all(f["meaning"] for f in facts)
    (pll,) = [f for f in facts if f["name"] == "smo_pll_hz"]
    assert (pll["type"], pll["unit"], pll["low"], pll["high"]) == ("float", "Hz", 1, 1000)
    words = [f"{name}={str(value).lower()}" for name, value in design.items() if name[0] != "L"]
    assert design_from(words) == DriveDesign()
    assert design_from(["smo_emf_hz=inf"]).smo_emf_hz == math.inf


def test_automatic_settings_are_those_of_the_machine() -> None:
    """The wheel machine accelerates eight times as fast as the paper's: faster loops."""
    text = RUNNER.invoke(app, ["settings", "--motor", "formula_wheel", "--json"]).output
    value = {f["name"]: f["value"] for f in json.loads(text) if "value" in f}
    assert value == asdict(derive(Motor.load("formula_wheel"), DriveDesign()))
    assert value["hfi_pll_hz"] > 2.0 * derive(Motor.load("paper"), DriveDesign()).hfi_pll_hz


def test_an_old_setting_is_refused_with_the_one_that_took_its_place() -> None:
    with pytest.raises(UserError, match=r"^set: smo_sign: is now smo_switching: write smo_swit"):
        design_from(["smo_sign=true"])
