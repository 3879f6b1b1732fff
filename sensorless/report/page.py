"""Writes a report as one HTML page that needs no other file."""

import base64
import inspect
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from sensorless.envs.scenarios.scenario import LOST_ANGLE_DEG, LOST_TIME
from sensorless.evaluation.metrics.catalogue import METRICS
from sensorless.evaluation.results import RATES, Results
from sensorless.evaluation.results_tables import (
    PLACE_COLUMNS,
    kept,
    number,
    rate,
    share,
    speed_labels,
)

TEMPLATE = "page.html.j2"

RATE_COLUMNS = (
    ("lost_rate", "lost [%]", 100.0, 1),
    ("not_held_rate", "not held [%]", 100.0, 1),
)
COLUMNS = (
    ("torque_dev_rms", "torque deviation [%]", 100.0, 2),
    ("torque_ripple_rms", "torque ripple [%]", 100.0, 2),
    ("torque_ripple_window", "ripple in the hand-over window [%]", 100.0, 2),
    ("torque_p2p_window", "peak to peak in the hand-over window [%]", 100.0, 1),
    ("overshoot_pct", "overshoot [%]", 1.0, 2),
    ("overshoot_excess_pct", "overshoot beyond the twin's [%]", 1.0, 2),
    ("overshoot_clean_pct", "overshoot where the twin has none [%]", 1.0, 2),
    ("overshoot_clean_above", "share with more than 2 % there [%]", 100.0, 1),
    ("angle_err_rms_deg", "angle error [°]", 1.0, 2),
    ("copper_extra", "extra copper loss [%]", 100.0, 2),
)
"""Columns of the results table: metric, heading, factor, decimals."""

LOST = (
    f"angle error above {LOST_ANGLE_DEG:g}° for more than {1e3 * LOST_TIME:g} ms, over-current, or "
    "a state that is not finite"
)
"""Definition of a lost scenario."""

PLACE_HEADINGS = ("torque deviation [%]", "torque ripple [%]", "angle error [°]")
"""Headings of ``results_tables.PLACE_COLUMNS`` in words."""


@dataclass(frozen=True)
class Figure:
    """A picture of the page, which is also a file beside it."""

    file: str
    title: str
    caption: str
    png: bytes
    command: str = ""
    """command that draws it again"""

    @property
    def uri(self) -> str:
        """Return the picture as a data URI."""
        return "data:image/png;base64," + base64.b64encode(self.png).decode("ascii")


@dataclass(frozen=True)
class Section:
    """Results of one suite on the page."""

    results: Results
    command: str
    """command that evaluates the same again"""
    figures: Sequence[Figure]


def render(
    name: str,
    about: Mapping[str, str],
    sections: Sequence[Section],
    figures: Sequence[Figure],
    commands: Sequence[tuple[str, str]],
    versions: Mapping[str, str],
    design: Mapping[str, Any],
) -> str:
    """Text of the page.

    Parameters
    ----------
    name : str
        Name of the policy that the report is about, the first one of every section.
    about : mapping
        Facts by label for the head of the page.
    sections, figures
    commands : pairs
        What was done, and the command that does it again.
    versions, design : mappings
    """
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(TEMPLATE).render(
        name=name,
        about=about,
        sections=[_section(s) for s in sections],
        figures=figures,
        rates=[heading for _, heading, _, _ in RATE_COLUMNS],
        lost=LOST,
        not_held=_formula("not_held"),
        columns=[heading for _, heading, _, _ in COLUMNS],
        formulas=[(heading, _formula(key)) for key, heading, _, _ in COLUMNS],
        place_columns=PLACE_HEADINGS,
        commands=commands,
        versions=versions,
        design=design,
    )


def _section(section: Section) -> dict[str, Any]:
    results = section.results
    return {
        "suite": results.suite,
        "setting": f"seed {results.seed}, {results.size} scenarios",
        "command": section.command,
        "rows": [
            {"note": results.note(name), **_row(name, policy)}
            for name, policy in results.policies.items()
        ],
        "pairs": [
            {"note": results.note(name), **_pair(name, results.policies[name]["bound"], pair)}
            for name, pair in results.paired.items()
        ],
        "places": [(name, _places(policy)) for name, policy in results.policies.items()],
        "worst": [
            (name, [_case(case) for case in policy["worst"]])
            for name, policy in results.policies.items()
        ],
        "figures": section.figures,
    }


def _row(name: str, policy: Mapping[str, Any]) -> dict[str, Any]:
    return {
        "name": name,
        "bound": policy["bound"],
        "cells": [
            _cell(
                factor * policy[key],
                [factor * x for x in policy[RATES.get(key, f"{key}_ci")]],
                decimals,
            )
            for key, _, factor, decimals in (*RATE_COLUMNS, *COLUMNS)
        ],
    }


def _cell(value: float, interval: Sequence[float], decimals: int) -> tuple[str, str]:
    """Number and interval; the interval is empty if there is none."""
    if not math.isfinite(interval[0]):
        return number(value, decimals), ""
    low, high = (number(x, decimals) for x in interval)
    return number(value, decimals), f"{low} … {high}"


def _pair(name: str, bound: bool, pair: Mapping[str, Any]) -> dict[str, Any]:
    """The report's policy minus this one: the opposite sign of the differences in the results."""
    cells = []
    for key, _, factor, decimals in (*RATE_COLUMNS, *COLUMNS):
        low, high = (-factor * x for x in reversed(pair[f"{key}_ci"]))
        text = _cell(-factor * pair[key], (low, high), decimals)
        percent = share(-pair[key], pair["there"][key] + pair[key])
        cells.append((*text, percent, "less" if high < 0.0 else "more" if low > 0.0 else ""))
    return {"name": name, "bound": bound, "both": pair["survived_both"], "cells": cells}


def _places(policy: Mapping[str, Any]) -> list[list[str]]:
    rows = []
    for block in (policy["by_quadrant"], policy["by_speed"]):
        labels = block["place"] if "place" in block else speed_labels(block["from_rated_speed"])
        for j, label in enumerate(labels):
            errors = (number(f * block[key][j], d) for key, _, f, d in PLACE_COLUMNS)
            share, lost = 100.0 * block["time_share"][j], block["lost_rate"][j]
            rows.append(
                [
                    label,
                    f"{share:.1f}",
                    str(block["came"][j]),
                    rate(lost, block["lost_ci"][j]),
                    *errors,
                ]
            )
    return rows


def _case(case: Mapping[str, Any]) -> dict[str, str]:
    where = f", {case['quadrant']}" if case["quadrant"] else ""
    return {
        "scenario": case["scenario"],
        "lost": f"{case['lost_cause']}{where}" if case["lost_cause"] else kept(dict(case)),
        "time": number(case["time_s"], 3),
        "deviation": number(100.0 * case["torque_dev_rms"], 2),
        "angle": number(case["angle_err_max_deg"], 1),
    }


def _formula(name: str) -> str:
    """First line of a metric's description, which is its formula."""
    return (inspect.getdoc(METRICS[name]) or "").splitlines()[0]
