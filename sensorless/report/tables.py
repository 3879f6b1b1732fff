"""Tables of a report as cells: text, interval and the number to sort by."""

import inspect
import math
from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np

from sensorless.envs.scenarios.scenario import LOST_ANGLE_DEG, LOST_TIME
from sensorless.evaluation.metrics.catalogue import METRICS
from sensorless.evaluation.results import RATES, Columns, Results
from sensorless.evaluation.results_tables import number, rate, share, speed_labels
from sensorless.machine.motor import Motor

COLUMNS: Columns = (
    ("lost_rate", "lost [%]", 100.0, 1),
    ("not_held_rate", "not held [%]", 100.0, 1),
    ("torque_dev_rms", "torque deviation [%]", 100.0, 2),
    ("torque_ripple_rms", "torque ripple [%]", 100.0, 2),
    ("torque_ripple_window", "ripple in the hand-over [%]", 100.0, 2),
    ("overshoot_pct", "overshoot [%]", 1.0, 2),
    ("overshoot_excess_pct", "overshoot beyond the twin’s [%]", 1.0, 2),
    ("angle_err_rms_deg", "angle error [°]", 1.0, 2),
    ("injection_share", "injection on [%]", 100.0, 1),
    ("copper_extra", "extra copper loss [%]", 100.0, 2),
)
"""Columns of the results: metric, heading, factor, decimals."""
PLACE_COLUMNS = (
    ("torque_dev_rms", "deviation [%]", 100.0, 2),
    ("angle_err_rms_deg", "angle [°]", 1.0, 2),
)
LOST = (
    f"angle error above {LOST_ANGLE_DEG:g}° for more than {1e3 * LOST_TIME:g} ms, over-current, or "
    "a state that is not finite"
)
"""Definition of a lost scenario."""

Row = dict[str, Any]


def result_rows(results: Results, shown: Sequence[str]) -> list[Row]:
    """One row a policy, those of ``shown`` first; the others are folded."""
    names = [*shown, *(name for name in results.policies if name not in shown)]
    return [
        {
            **_head(results, name, shown),
            "cells": [
                _cell(p[key], p[RATES.get(key, f"{key}_ci")], factor, decimals)
                for key, _, factor, decimals in COLUMNS
            ],
        }
        for name in names
        for p in [results.policies[name]]
    ]


def pair_rows(results: Results, shown: Sequence[str], apart: Collection[str] = ()) -> list[Row]:
    """The first policy minus each other: the opposite sign of the differences in the results.

    Beside those with another control, ``apart``, nothing is better or worse.
    """
    names = [name for name in shown if name in results.paired]
    names += [name for name in results.paired if name not in shown]
    return [
        {
            **_head(results, name, shown),
            "both": results.paired[name]["survived_both"],
            "cells": [
                _difference(results.paired[name], key, x, n)
                | ({"word": ""} if name in apart else {})
                for key, _, x, n in COLUMNS
            ],
        }
        for name in names
    ]


def _head(results: Results, name: str, shown: Sequence[str]) -> Row:
    first = next(iter(results.policies))
    bound = results.policies[name]["bound"]
    kind = "own" if name == first else "bound" if bound else ""
    return {
        "name": name,
        "note": results.note(name),
        "kind": kind if name in shown else f"{kind} rest".strip(),
    }


def _cell(value: float, interval: Sequence[float], factor: float, decimals: int) -> Row:
    low, high = (number(factor * x, decimals) for x in interval)
    known = math.isfinite(value)
    return {
        "text": number(factor * value, decimals),
        "interval": f"{low} … {high}" if math.isfinite(interval[0]) else "",
        "value": f"{factor * value:.6g}" if known else "",
        "word": "",
        "share": "",
    }


def _difference(pair: Mapping[str, Any], key: str, factor: float, decimals: int) -> Row:
    low, high = (-x for x in reversed(pair[f"{key}_ci"]))
    cell = _cell(-pair[key], (low, high), factor, decimals)
    percent = share(-pair[key], pair["there"][key] + pair[key])
    word = "better" if high < 0.0 else "worse" if low > 0.0 else ""
    return {**cell, "word": word, "share": percent}


def place_rows(results: Results, names: Sequence[str]) -> list[Row]:
    """One row a place: how many came, and what each of the policies did there."""
    rows = []
    for block in ("by_quadrant", "by_speed"):
        sides = [results.policies[name][block] for name in names]
        first = sides[0]
        labels = first["place"] if "place" in first else speed_labels(first["from_rated_speed"])
        for j, label in enumerate(labels):
            cells = [
                {"text": rate(s["lost_rate"][j], s["lost_ci"][j]), "value": s["lost_rate"][j]}
                for s in sides
            ]
            cells += [
                {"text": number(factor * s[key][j], decimals), "value": s[key][j]}
                for key, _, factor, decimals in PLACE_COLUMNS
                for s in sides
            ]
            rows.append({"label": label, "came": first["came"][j], "cells": cells})
    return rows


def machine_rows(results: Results, names: Sequence[str]) -> list[Row]:
    """One row a machine: what each policy lost and how far it deviates; none of one machine."""
    if "by_machine" not in results.policies[names[0]]:
        return []
    sides = [results.policies[name]["by_machine"] for name in names]
    lost, off = "lost", "torque_dev_rms"
    return [
        {
            "label": label,
            "came": sides[0]["feasible"][j],
            "cells": [{"text": f"{s[lost][j]}", "value": s[lost][j]} for s in sides]
            + [
                {"text": number(100.0 * s[off][j], 2), "value": f"{100.0 * s[off][j]:.6g}"}
                for s in sides
            ],
        }
        for j, label in enumerate(sides[0]["machine"])
    ]


def said(results: Results, name: str) -> str:
    """Where a policy fails, in words."""
    policy = results.policies[name]
    places = []
    for block in (policy["by_quadrant"], policy["by_speed"]):
        labels = block["place"] if "place" in block else speed_labels(block["from_rated_speed"])
        places += [
            (block["lost"][j], block["came"][j], block["torque_dev_rms"][j], label)
            for j, label in enumerate(labels)
        ]
    lost, came, _, label = max(places, key=lambda p: p[0] / max(p[1], 1))
    if lost:
        return f"{results.suite}: it loses most at {label}, {lost} of {came} that came there."
    known = [p for p in places if math.isfinite(p[2])]
    if not known:
        return f"{results.suite}: nothing to say."
    *_, deviation, label = max(known, key=lambda p: p[2])
    off = f"its torque is most off at {label}, by {number(100.0 * deviation, 1)} % of rated"
    return f"{results.suite}: nothing is lost; {off}."


def held(envelope: Results, motor: Motor) -> str:
    """Where over speed and load the first policy keeps lock, in words."""
    texts: list[str] = []
    for name, policy in envelope.policies.items():
        lost = np.array(policy["scenarios"]["lost"])
        able = sum("twin" not in (c or "") for c in policy["scenarios"]["lost_cause"])
        text = f"{name} keeps lock in {able - int(lost.sum())} of {able} points"
        if lost.any() and not texts:
            side = math.isqrt(len(lost))
            grid = np.linspace(-1.0, 1.0, side)
            speed, load = np.divmod(np.flatnonzero(lost), side)
            ends = [(min(x), max(x)) for x in (grid[speed], grid[load])]
            (a, b), (c, d) = ends
            text += (
                f", and loses the others between {number(a * motor.n_rated_rpm, 0)} and "
                f"{number(b * motor.n_rated_rpm, 0)} r/min, {number(c * motor.tau_rated, 1)} and "
                f"{number(d * motor.tau_rated, 1)} N m"
            )
        texts.append(text)
    return f"Over speed and load: {'; '.join(texts)}."


def formulas() -> list[tuple[str, str]]:
    """Heading of each column and the first line of its metric's description."""
    known = [("lost", LOST), ("feasible", "the sensored twin neither trips nor runs away")]
    known.append(("not held", _formula("not_held")))
    return known + [(h.rsplit(" [", 1)[0], _formula(k)) for k, h, _, _ in COLUMNS if k in METRICS]


def _formula(name: str) -> str:
    return (inspect.getdoc(METRICS[name]) or "").splitlines()[0]
