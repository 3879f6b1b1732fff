"""The playground in Chromium: the native core's bits, its controls, no request to anywhere."""

import base64
import json
import time
from pathlib import Path

import numpy as np
import pytest

from sensorless.core.api import SIM, TRACE_NAMES
from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.words import plan_from
from sensorless.evaluation.trace import trace
from sensorless.machine.motor import Motor
from sensorless.policies.registry import make_policy
from tests.web.conftest import Shown
from tests.web.native import Move, final
from web.audit import CHECKS
from web.browser import prefer, size_to
from web.build import MOST_BYTES

NAMES = ("speed", "ramp", "load", "resistance", "magnet", "inertia", "link", "gain", "offset")
"""Order of the levers in a link."""
PATIENCE = 30.0
"""Longest time to wait for the page [s]."""


def link(
    motor: str, sides: list[str], levers: dict[str, float], moves: list[Move], decisions: int
) -> str:
    """Fragment of the address that describes a run."""
    words = [f"{key}={side.replace(' ', '+')}" for key, side in zip("ab", sides, strict=False)]
    told = "+".join(f"{at}_{target}_{value}" for at, target, value in moves)
    start = "+".join(f"{levers[name]:g}" for name in NAMES)
    return "#" + "&".join([f"m={motor}", *words, f"l={start}", f"v={told}", f"t={decisions}"])


def wait(shown: Shown, condition: str) -> None:
    """Until the page has it."""
    end = time.monotonic() + PATIENCE
    while not shown.run(f"return Boolean(window.playground && ({condition}))"):
        assert time.monotonic() < end, condition
        time.sleep(0.02)


def follow(shown: Shown, fragment: str) -> None:
    """Open a link, once the page is there."""
    wait(shown, "playground.page.pace")
    shown.run("playground.page.pace.stop(); location.hash = arguments[0]", fragment)


def repeat(shown: Shown, fragment: str, decisions: int) -> None:
    """Open a link and wait until its run is where it was shared."""
    follow(shown, fragment)
    wait(shown, f"playground.page.run.decision === {decisions} && !playground.page.pace.running")


def state(shown: Shown, side: int) -> np.ndarray:
    """Bytes of a drive's record in the page."""
    text = shown.run("return playground.state(arguments[0])", side)
    return np.frombuffer(base64.b64decode(text), dtype=np.uint8)


LEVERS = {
    **{"speed": 90.0, "ramp": 900.0, "load": 5.6},
    **{"resistance": 137.0, "magnet": 93.0, "inertia": 140.0, "link": 95.0},
    **{"gain": 102.0, "offset": 0.05},
}
MOVES: list[Move] = [(300, "speed", 700.0), (900, "load", -3.2), (1100, "speed", -450.0)]


def test_state_has_the_bytes_of_the_native_core(shown: Shown, motor: Motor) -> None:
    sides = ["coupled reference", "smo sliding_mode"]
    repeat(shown, link(motor.name, sides, LEVERS, MOVES, 1600), 1600)
    for i, side in enumerate(sides):
        estimator, word = side.split(" ")
        native = final(motor, estimator, word, LEVERS, MOVES, 1600)
        assert native["lost"][0] == 0
        assert np.array_equal(state(shown, i), native.view(np.uint8)), side


def test_other_machine_has_them_too(shown: Shown) -> None:
    """Its magnet stands in another number of the flux map, and its period is shorter."""
    machine = Motor.load("pmsyrm_5600w")
    levers = {**LEVERS, "speed": 600.0, "load": 4.0, "magnet": 80.0}
    repeat(shown, link(machine.name, ["flux flux_observer"], levers, [], 700), 700)
    native = final(machine, "flux", "flux_observer", levers, [], 700)
    assert np.array_equal(state(shown, 0), native.view(np.uint8))


def test_start_without_the_angle_has_them_too(shown: Shown, motor: Motor) -> None:
    repeat(shown, link(motor.name, ["coupled eq25"], LEVERS, [], 500) + "&k=1&s=3", 500)
    native = final(motor, "coupled", "eq25", LEVERS, [], 500, seek=True, seed=3)
    assert native["start"]["seek"][0] == 1
    assert native["drive"]["x"]["start"]["phase"][0] == 0
    assert np.array_equal(state(shown, 0), native.view(np.uint8))


def test_scenario_shows_the_numbers_of_simulate(shown: Shown, motor: Motor) -> None:
    """The steps of Fig. 9: the last row of a trace is that of ``sensorless simulate``."""
    levers = {
        **dict.fromkeys(NAMES, 100.0),
        "speed": 200.0,
        "ramp": 0.0,
        "load": 0.0,
        "offset": 0.0,
    }
    moves: list[Move] = [(1000, "speed", 350.0), (2000, "speed", 600.0)]
    repeat(shown, link(motor.name, ["coupled eq25"], levers, moves, 2500), 2500)
    row = shown.run("const c = playground.page.core; return [...c.rows.slice(0, 5 * c.rowLength)]")
    plan = plan_from("0:200,1:350,2:600", "0:0", None, 2.5, motor, 0)
    native = trace(make_policy("eq25", motor), plan, motor, DriveDesign())
    last = [float(native[name][-1]) for name in TRACE_NAMES]
    assert np.asarray(row).reshape(5, -1)[-1].tolist() == last


def test_link_repeats_what_was_moved(shown: Shown, motor: Motor) -> None:
    """Levers and nodes of a table that were moved while it ran, at their instants."""
    repeat(shown, link(motor.name, ["coupled reference"], LEVERS, MOVES, 400), 400)
    shown.run(
        "const p = playground.page; p.run.move('inertia', 250); p.run.move('a12*', 0.25);"
        "for (let j = 0; j < 300; j++) p.run.advance();"
    )
    before = state(shown, 0)
    shown.run("playground.page.share()")
    fragment = shown.run("return location.hash")
    repeat(shown, link(motor.name, ["smo eq25"], LEVERS, [], 5), 5)
    assert not np.array_equal(state(shown, 0), before)
    repeat(shown, fragment, 700)
    assert np.array_equal(state(shown, 0), before)
    assert shown.run("return playground.page.run.drives[0].table.refused") == 0
    repeat(shown, fragment.replace("#c=", "#c=0"), 700)
    assert "another version" in shown.run("return document.getElementById('message').textContent")
    shown.run("document.getElementById('message').textContent = ''")


@pytest.mark.parametrize("fragment", ["#m=none", "#m=paper&a=coupled+eq25&l=1", "#m=paper&a=x+y"])
def test_foreign_link_is_refused_in_words(shown: Shown, fragment: str) -> None:
    follow(shown, fragment)
    wait(shown, "document.getElementById('message').textContent.includes('link')")
    shown.run("document.getElementById('message').textContent = ''; playground.page.pace.stop()")


def test_slider_moves_the_drive(shown: Shown, motor: Motor) -> None:
    """By its keys, as a hand would; the record of the drive has what the slider says."""
    repeat(shown, link(motor.name, ["coupled eq25"], LEVERS, [], 10), 10)
    slider = shown.driver.find_element("id", "lever-load")
    was = float(slider.get_property("value"))
    slider.send_keys("\ue014" * 5)  # arrow to the right
    now = float(slider.get_property("value"))
    assert now > was
    record = state(shown, 0).view(SIM)
    assert record["profile"]["tau"][0, 0] == np.float32(now)


def test_node_of_the_table_is_dragged(shown: Shown, motor: Motor) -> None:
    """By the pointer; then by a key. Another rule on the other drive leaves it as it is."""
    from selenium.webdriver import ActionChains

    repeat(shown, link(motor.name, ["coupled eq25", "smo eq25"], LEVERS, [], 10), 10)
    node = shown.driver.find_elements("css selector", "#curve .node")[1]
    assert float(node.get_attribute("aria-valuenow")) == 0.0
    ActionChains(shown.driver).drag_and_drop_by_offset(node, 0, -60).perform()
    dragged = float(node.get_attribute("aria-valuenow"))
    assert 0.05 < dragged < 0.95
    node.send_keys("\ue013")  # arrow up
    values = "return [...playground.page.run.drives[0].table.values]"
    assert shown.run(values) == pytest.approx([1.0, dragged + 0.05])
    shown.run(
        "const list = document.getElementById('rule-B'); list.value = 'smoothstep';"
        "list.dispatchEvent(new Event('change')); playground.page.pace.stop();"
    )
    assert shown.run(values) == pytest.approx([1.0, dragged + 0.05])
    assert shown.run("return playground.page.run.drives[1].table.n") == 65


def test_node_is_dragged_by_touch(shown: Shown, motor: Motor) -> None:
    repeat(shown, link(motor.name, ["coupled own"], LEVERS, [], 10), 10)
    script = (
        "const node = document.querySelectorAll('#curve .node')[8];"
        "node.scrollIntoView({ block: 'center' }); const box = node.getBoundingClientRect();"
        "return [box.x + box.width / 2, box.y + box.height / 2];"
    )
    x, y = shown.run(script)
    for kind, at in (("touchStart", y), ("touchMove", y - 20), ("touchMove", y - 50)):
        shown.driver.execute_cdp_cmd(
            "Input.dispatchTouchEvent", {"type": kind, "touchPoints": [{"x": x, "y": at}]}
        )
    shown.driver.execute_cdp_cmd(
        "Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []}
    )
    values = shown.run("return [...playground.page.run.drives[0].table.values]")
    assert 0.1 < values[8] < 0.9
    assert values[9] == 0.0


def test_keys_run_pause_and_restart(shown: Shown, motor: Motor) -> None:
    repeat(shown, link(motor.name, ["coupled eq25"], LEVERS, [], 2000), 2000)
    body = shown.driver.find_element("tag name", "body")
    body.send_keys(" ")
    wait(shown, "playground.page.pace.running && playground.page.run.decision > 2000")
    body.send_keys(" ")
    assert not shown.run("return playground.page.pace.running")
    body.send_keys("r")
    wait(shown, "playground.page.pace.running")
    assert shown.run("return playground.page.run.decision") < 2000
    shown.run("playground.page.pace.stop()")


def test_lost_drive_is_told(shown: Shown, motor: Motor) -> None:
    """The observer alone cannot see a shaft that rests. The run ends with its last drive."""
    levers = {**LEVERS, "speed": 0.0, "load": 10.0}
    follow(shown, link(motor.name, ["smo constant:0"], levers, [], 200))
    wait(shown, "playground.page.goal === 200 && !playground.page.pace.running")
    ended = shown.run("return playground.page.run.decision")
    before, native = (final(motor, "smo", "constant:0", levers, [], n) for n in (ended - 1, ended))
    assert before["lost"][0] == 0 != native["lost"][0]
    assert np.array_equal(state(shown, 0), native.view(np.uint8))
    assert "angle error" in shown.run("return document.getElementById('events').textContent")


def test_every_control_has_a_name(shown: Shown) -> None:
    assert shown.run(CHECKS + "return unnamed();") == []


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_contrast_is_aa(shown: Shown, scheme: str) -> None:
    prefer(shown.driver, scheme)
    assert shown.run(CHECKS + "return faint(4.5);") == []


@pytest.mark.parametrize(("width", "height"), [(1440, 900), (390, 844)])
def test_pictures_are_drawn_at_any_width(
    shown: Shown, motor: Motor, tmp_path: Path, width: int, height: int
) -> None:
    """Both drives' colours are on every plot, and nothing is wider than the window."""
    prefer(shown.driver, "light")
    size_to(shown.driver, width, height, mobile=width < 500)
    sides = ["coupled reference", "smo sliding_mode"]
    repeat(shown, link(motor.name, sides, LEVERS, MOVES, 1600), 1600)
    wait(shown, "playground.page.plots.plots[0].width > 0")
    assert shown.run("return document.documentElement.scrollWidth") <= width
    assert shown.driver.save_screenshot(str(tmp_path / f"{width}.png"))
    shown.driver.execute_async_script("requestAnimationFrame(arguments[0])")
    assert shown.run(CHECKS + "return uncoloured();") == []


def test_page_is_small_quick_and_alone(shown: Shown) -> None:
    """Its weight, its first paint, its console, and its requests, from opening to a run's end."""
    assert shown.size <= MOST_BYTES
    for log in ("browser", "performance"):
        shown.driver.get_log(log)
    shown.driver.get(shown.file.as_uri())
    repeat(shown, link("paper", ["coupled eq25"], LEVERS, [], 300), 300)
    paint = shown.run("return performance.getEntriesByName('first-contentful-paint')[0].startTime")
    assert paint < 2000.0
    assert [e for e in shown.driver.get_log("browser") if e["level"] != "DEBUG"] == []
    told = [
        json.loads(entry["message"])["message"] for entry in shown.driver.get_log("performance")
    ]
    asked = [m["params"] for m in told if m["method"] == "Network.requestWillBeSent"]
    urls = {params["request"]["url"].split("#")[0] for params in asked}
    assert {url for url in urls if not url.startswith("data:")} == {shown.file.as_uri()}
