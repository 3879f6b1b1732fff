"""Pages of one run: a machine's check, a simulation, a replayed log."""

from pathlib import Path
from typing import Any

import pytest

from tests.helpers.command import run
from web.audit import audit

COMMANDS = {
    "check": "motor check pmsyrm_5600w --size 2 --out",
    "constant": "motor check formula_wheel --size 0 --out",
    "simulate": "simulate --speed 0:300 --duration 0.2 --plot",
    "replay": "replay sample --plot",
}
MOST = 1_000_000
"""Largest page [bytes]."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("pages")


@pytest.mark.parametrize("name", COMMANDS)
def test_nothing_is_wrong_with_the_page(driver: Any, folder: Path, name: str) -> None:
    page = folder / f"{name}.html"
    done = run(*COMMANDS[name].split(), page.name, cwd=folder)
    assert done.returncode == 0, done.stderr
    assert audit(driver, page, MOST) == []
    assert driver.execute_script("return document.querySelectorAll('canvas').length") >= 3


def test_curves_of_a_machine_follow_the_theme_and_start_at_zero(driver: Any, folder: Path) -> None:
    """No picture in them stays white, and a constant does not fill its plot with rounding."""
    page = folder / "brusa.html"
    run("motor", "check", "brusa_hsm1", "--size", "0", "--out", page.name, cwd=folder)
    driver.get(page.as_uri())
    driver.execute_async_script("requestAnimationFrame(arguments[0])")
    assert driver.execute_script("return document.images.length") == 0
    lows = "return [...drawn.values()].flat().map((u) => u.scales.y.min)"
    assert driver.execute_script(lows) == [0.0] * 4


def test_the_rated_point_is_within_the_reach_of_the_rated_current() -> None:
    """As the check says in words: 31.5 N m at 1800 r/min, where 29.7 are rated."""
    from sensorless.machine.motor import Motor
    from sensorless.machine.rated_point import rated_point
    from sensorless.report.machine_curves import reach

    motor = Motor.load("pmsyrm_5600w")
    panel = reach(motor)
    at = panel["x"].index(motor.n_rated_rpm)
    most, rated, point = (curve["values"][at] for curve in panel["curves"])
    assert point == motor.tau_rated < rated < most
    assert rated == pytest.approx(rated_point(motor).torque_at_speed, rel=0.01)
