"""Whether tuned gains are better than their start, on scenarios that tuning has not seen."""

import math
from typing import Any

from sensorless.design.drive import DriveDesign
from sensorless.envs.scenarios.suites import suite
from sensorless.evaluation.aggregate import mean_interval
from sensorless.evaluation.compare import SEED, SIZE, comparison
from sensorless.machine.motor import Motor
from sensorless.plain_json import plain
from sensorless.policy import Policy
from sensorless.tuning.gains.choice import with_gains
from sensorless.tuning.gains.measure import (
    KEPT,
    Measured,
    cost,
    joined,
    measure,
    not_held_rate,
    pairs,
    rise,
)
from sensorless.tuning.gains.search import SUITES, Search

START = "the gains that it started from"


def judged(motor: Motor, design: DriveDesign, policy: Policy, found: Search) -> dict[str, Any]:
    """Verdict, and the numbers of tuned gains and start by suite, in JSON types."""
    if not found.best:
        sentence = (
            f"the same as {START}: nothing better that is as exact, as fast and as well held was "
            f"found in {found.tried} sets of gains"
        )
        cheapest = min((c.objective for c in found.centres), default=math.inf)
        if cheapest < found.start_value:
            sentence += f"; without that, objective {cheapest:.3f} instead of "
            sentence += f"{found.start_value:.3f}"
        return {"verdict": sentence}
    runs: dict[str, list[Measured]] = {"start": [], "tuned": []}
    drives = {"start": design, "tuned": with_gains(design, found.best)}
    for name, share in SUITES.items():
        scenarios = suite(name, motor, SEED, round(share * SIZE))
        for who, drive in drives.items():
            runs[who].append(measure(motor, drive, policy, scenarios))
    start, ours = joined(runs["start"]), joined(runs["tuned"])
    where = " and ".join(SUITES)
    facts = comparison(ours.outcomes(), start.outcomes(), START, where).facts()
    facts["suites"] = {
        name: beside(runs["tuned"][i], runs["start"][i]) for i, name in enumerate(SUITES)
    }
    facts["kept"] = {name: changed(name, ours, start) for name in KEPT}
    risen = [
        f"{name} {100.0 * found['change']:+.1f} %"
        for name, found in facts["kept"].items()
        if found["interval"][0] is not None and found["interval"][0] > 0.0
    ]
    ours_loose, loose = (round(not_held_rate(x, start) * facts["scenarios"]) for x in (ours, start))
    if ours_loose > loose:
        risen.append(f"{ours_loose} not held instead of {loose}")
    if risen:
        facts["verdict"] += f"; but {' and '.join(risen)}"
    return facts


def beside(ours: Measured, start: Measured) -> dict[str, dict[str, float | None]]:
    """Cost, rate of drives not held and ``KEPT`` of start and tuned gains."""
    out: dict[str, dict[str, float | None]] = {}
    for who, found in {"start": start, "tuned": ours}.items():
        out[who] = {**vars(cost(found, start)), "not_held_rate": not_held_rate(found, start)}
    for name in KEPT:
        for who, values in zip(("tuned", "start"), pairs(name, ours, start), strict=True):
            out[who][name] = float(values.mean()) if len(values) else None
    return out


def changed(name: str, ours: Measured, start: Measured) -> dict[str, Any]:
    """Change of one of ``KEPT`` over the start's mean, with its 95 % interval."""
    here, there = pairs(name, ours, start)
    mean = float(there.mean()) if len(there) else 0.0
    interval = mean_interval((here - there) / mean, SEED) if mean > 0.0 else (math.nan, math.nan)
    return {"change": rise(name, ours, start), "interval": plain(interval)}
