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
