"""The report in Chromium: what it weighs and shows, sorting, waveforms on a click, zoom."""

import time
from pathlib import Path
from typing import Any

import pytest

from sensorless.design.drive import DriveDesign
from sensorless.machine.motor import Motor
from sensorless.policies.bench import Bench
from sensorless.report.report import Report
from web.audit import audit
from web.browser import size_to

pytestmark = pytest.mark.usefixtures("short_suites")

MOST = 3_000_000
"""Largest page [bytes]."""
RANGE = "return [...drawn.values()][0][0].scales.x.max - [...drawn.values()][0][0].scales.x.min"


@pytest.fixture(scope="module")
def page(driver: Any, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report of every part but learning curves, with more policies than it shows."""
    bench = Bench(Motor.load("paper"), DriveDesign())
    others = ["eq25", "linear-coupled-tuned", "sliding_mode", "hysteresis", "logistic", "sensored"]
    report = Report("linear:100,700", bench, others=others)
    folder = tmp_path_factory.mktemp("report")
    return report.write(folder, ["stress-1"], 7, 4, 3, "sensorless report")[0]


def wait(driver: Any, script: str, wanted: object = True) -> None:
    end = time.monotonic() + 20.0
    while driver.execute_script(script) != wanted:
        assert time.monotonic() < end, script
        time.sleep(0.02)


def test_nothing_is_wrong_with_the_page(driver: Any, page: Path) -> None:
    assert audit(driver, page, MOST) == []


def test_the_command_of_the_maps_names_every_policy_that_they_show(page: Path) -> None:
    sides = ("linear:100,700", "eq25", "linear-coupled-tuned")
    words = " ".join(f"--policy {name}" for name in sides)
    assert f"{words} --suite envelope" in page.read_text(encoding="utf-8")


def test_a_heading_sorts(driver: Any, page: Path) -> None:
    driver.get(page.as_uri())
    column = """
        const table = document.querySelector("#all ~ .fold table");
        const button = table.tHead.rows[0].cells[3].querySelector("button");
        button.click();
        return [[...table.tBodies[0].rows].map((row) => Number(row.cells[3].dataset.v)),
                button.parentElement.ariaSort];
    """
    for order, down in (("descending", True), ("ascending", False)):
        values, said = driver.execute_script(column)
        assert said == order
        assert values == sorted(values, reverse=down)
        assert len(set(values)) > 3


def test_five_policies_are_shown_and_the_others_on_demand(driver: Any, page: Path) -> None:
    driver.get(page.as_uri())
    count = """
        const rows = document.querySelector("#all ~ .fold").querySelectorAll("tbody tr");
        return [...rows].filter((row) => row.checkVisibility()).length;
    """
    assert driver.execute_script(count) == 5
    driver.find_element("css selector", "#all ~ .fold input").click()
    assert driver.execute_script(count) == 7


def test_a_click_on_a_worst_case_shows_its_waveforms(driver: Any, page: Path) -> None:
    driver.get(page.as_uri())
    canvases = "return document.querySelectorAll('#waves canvas').length"
    wait(driver, canvases, 8)
    button = driver.find_elements("css selector", "button[data-show]")[2]
    word = button.get_attribute("data-show")
    driver.execute_script("arguments[0].click()", button)
    titles = "return [...document.querySelectorAll('#waves h4')].map((e) => e.textContent)"
    wait(driver, f"return document.querySelector('#waves h4')?.textContent.startsWith('{word} ')")
    wait(driver, canvases, 8)
    assert [title.split(" ")[2] for title in driver.execute_script(titles)] == [
        "linear:100,700:",
        "eq25:",
    ]
    driver.execute_script("document.getElementById('more').click()")
    wait(driver, canvases, 12)


def test_dragging_zooms_both_sides(driver: Any, page: Path) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    driver.get(page.as_uri())
    wait(driver, "return document.querySelectorAll('#waves canvas').length", 8)
    whole = driver.execute_script(RANGE)
    plot = driver.find_element("css selector", "#waves .u-over")
    driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", plot)
    ActionChains(driver).move_to_element(plot).click_and_hold().move_by_offset(
        80, 0
    ).release().perform()
    wait(driver, f"{RANGE} < {0.6 * whole}")
    ends = "return [...drawn.values()][0].map((u) => u.scales.x.max.toFixed(3))"
    assert len(set(driver.execute_script(ends))) == 1


def test_a_map_is_read_by_keys_by_touch_and_as_a_table(driver: Any, page: Path) -> None:
    """The first row of the table is the highest load, its first column the lowest speed."""
    driver.get(page.as_uri())
    canvas = driver.find_element("css selector", ".map canvas")
    said = "return document.querySelector('.map output').textContent"
    canvas.send_keys("\ue012" * 3 + "\ue013" * 3)  # arrows to the left, then up
    assert driver.execute_script("return document.activeElement.tagName") == "CANVAS"
    corner = driver.execute_script(said)
    assert corner.startswith("−1500, 14: ") and corner[-1] == "°"
    driver.find_element("css selector", ".map summary").click()
    wait(driver, "return document.querySelectorAll('.map table tr').length", 4)
    first = "return document.querySelector('.map tbody td').textContent"
    assert driver.execute_script(first) == corner.removeprefix("−1500, 14: ")
    driver.execute_script("document.activeElement.blur(); arguments[0].scrollIntoView()", canvas)
    assert driver.execute_script(said) == ""
    box = driver.execute_script("return arguments[0].getBoundingClientRect().toJSON()", canvas)
    at = {"x": box["x"] + 0.9 * box["width"], "y": box["y"] + 0.9 * box["height"]}
    for kind, points in (("touchStart", [at]), ("touchEnd", [])):
        touch = {"type": kind, "touchPoints": points}
        driver.execute_cdp_cmd("Input.dispatchTouchEvent", touch)
    assert driver.execute_script(said).startswith("1500, −14: ")


def test_both_sides_have_the_same_scale_but_for_a_zoom(driver: Any, page: Path) -> None:
    driver.get(page.as_uri())
    wait(driver, "return document.querySelectorAll('#waves canvas').length", 8)
    ends = """
        const sides = [...drawn.get(document.getElementById("waves"))];
        return sides.map(({ scales: { y } }) => [y.min, y.max]);
    """
    driver.execute_async_script("requestAnimationFrame(arguments[0])")
    whole = driver.execute_script(ends)
    assert all(here == there for here, there in zip(whole[::2], whole[1::2], strict=True))
    zoom = "for (const u of drawn.get(document.getElementById('waves'))) u.setScale('x', {0});"
    driver.execute_script(zoom.replace("{0}", "{min: 0.5, max: 0.51}"))
    driver.execute_async_script("requestAnimationFrame(arguments[0])")
    assert driver.execute_script(ends) != whole
    driver.find_element("id", "whole").click()
    wait(driver, "return document.querySelectorAll('#waves canvas').length", 8)
    driver.execute_async_script("requestAnimationFrame(arguments[0])")
    assert driver.execute_script(ends) == whole


def test_it_prints_on_a4(driver: Any, page: Path) -> None:
    """No table is wider than the paper: 210 mm less both margins."""
    driver.get(page.as_uri())
    size_to(driver, 703, 1000)
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    wide = (
        "return [...document.querySelectorAll('table')].filter((t) => t.offsetWidth > 703).length"
    )
    try:
        assert driver.execute_script(wide) == 0
    finally:
        driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})
        size_to(driver, 1280, 800)
