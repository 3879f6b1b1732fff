"""How many times faster than real time the playground runs in Chromium, for each machine.

Usage: python -m benchmarks.playground, on a computer that does nothing else.
"""

import sys
import tempfile
import time
from pathlib import Path

from benchmarks.words import parser
from web.browser import chromium, missing_browser, size_to
from web.build import build
from web.wasm import missing_tools

CHOOSE = """
const [motor, two] = arguments;
const { page } = playground;
const chooser = document.getElementById("motor");
chooser.value = motor;
chooser.dispatchEvent(new Event("change"));
const both = document.getElementById("compare");
if (both.checked !== two) both.click();
document.getElementById("scenario").value = "free";
page.again({ moves: [], sides: page.run.sides.map(() => page.run.sides.at(-1)) });
page.setFactor(arguments[2]);
"""
ALONE = """
const { run, pace } = playground.page;
pace.stop();
run.move("speed", run.setup.motor.rpm / 2);
const begin = performance.now();
const from = run.seconds;
while (run.seconds < from + 5) run.advance();
return 5000 / (performance.now() - begin);
"""
FASTEST = 8
"""Index of 50 times real time among the paces of the page."""
SECONDS = 4.0
"""Watched per machine."""


def main() -> None:
    """Print the pace of computing alone, and that of the page with its pictures."""
    parser(__doc__).parse_args()
    missing = [*missing_tools(), *missing_browser()]
    if missing:
        sys.exit(f"error: playground: needs {', '.join(missing)}")
    with tempfile.TemporaryDirectory() as folder, chromium() as driver:
        page = Path(folder, "playground.html")
        build(page)
        size_to(driver, 1280, 800)
        driver.get(page.as_uri())
        time.sleep(1.0)
        motors = driver.execute_script("return playground.page.layout.motors.map((m) => m.name)")
        print(f"{'machine':16}{'drives':>7}{'computing alone':>17}{'page at 50':>12}")
        for motor in motors:
            for two in (False, True):
                driver.execute_script(CHOOSE, motor, two, FASTEST)
                time.sleep(SECONDS)
                reached, lost = driver.execute_script(
                    "const { pace, run } = playground.page; return [pace.reached, run.over];"
                )
                alone = driver.execute_script(ALONE)
                note = "  lost" if lost else ""
                print(f"{motor:16}{1 + two:7}{alone:17.0f}{reached:12.1f}{note}")


if __name__ == "__main__":
    main()
