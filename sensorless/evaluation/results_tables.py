"""Tables for the terminal: where a policy loses, its worst scenarios, paired differences."""

import math
from itertools import pairwise
from typing import Any

from sensorless.evaluation.results import COLUMNS, Columns, Results
from sensorless.plain_table import PlainTable

PLACE_COLUMNS = (
    ("torque_dev_rms", "dev.\n[%]", 100.0, 2),
    ("torque_ripple_rms", "ripple\n[%]", 100.0, 2),
    ("angle_err_rms_deg", "angle\n[°]", 1.0, 2),
)
"""Columns of a table by place: name, heading, factor, decimals."""


def worst_table(results: Results, count: int, given: str = "") -> PlainTable | None:
    """The ``count`` worst scenarios of each policy, named for ``simulate --scenario``.

    Bounds, which know the truth, are left out; None if there is nothing else. ``given``: options
    that chose motor and drive.
    """
    if all(policy["bound"] for policy in results.policies.values()):
        return None
    again = " ".join(filter(None, (given, "--policy POLICY --scenario SCENARIO")))
    table = PlainTable(title="worst cases", caption=f"replay one with: sensorless simulate {again}")
    table.add_column("policy", overflow="fold")
    table.add_column("scenario", no_wrap=True)
    table.add_column("outcome")
    for heading in ("lived\n[s]", "torque\ndev. [%]", "largest angle\nerror [°]"):
        table.add_column(heading, justify="right")
    for name, policy in results.policies.items():
        for j, case in enumerate([] if policy["bound"] else policy["worst"][:count]):
            where = f", {case['quadrant']}" if case["quadrant"] else ""
            table.add_row(
                name if j == 0 else "",
                case["scenario"],
                f"{case['lost_cause']}{where}" if case["lost_cause"] else kept(case),
                f"{case['time_s']:.3f}",
                number(100.0 * case["torque_dev_rms"], 2),
                number(case["angle_err_max_deg"], 1),
                end_section=j == count - 1,
            )
    return table


def machines_table(results: Results) -> PlainTable:
    """Losses by machine, and errors beside the first policy's, of the suite ``machines``."""
    first = next(iter(results.policies))
    caption = (
        f"lost on: machines with any loss. Others: {first} is 100 %, geometric mean over "
        "the machines (95 % interval over machines), and the share of machines on which the policy "
        "is at most 2 % worse."
    )
    table = PlainTable(title=f"machine by machine, beside {first}", caption=caption)
    table.add_column("policy", overflow="fold")
    for heading in (
        "lost on",
        "torque dev. [%]",
        "as good\non [%]",
        "ripple [%]",
        "as good\non [%]",
    ):
        table.add_column(heading, justify="right")
    for name, policy in results.policies.items():
        lost = policy["by_machine"]["lost"]
        cells = [f"{sum(n > 0 for n in lost)} of {len(lost)}"]
        pair = results.paired[name]["by_machine"] if name in results.paired else None
        for key in ("torque_dev_rms", "torque_ripple_rms"):
            cells.append(rate(pair[key], pair[f"{key}_ci"]) if pair else "100")
            cells.append(number(100.0 * pair[f"{key}_as_good"], 0) if pair else "")
        table.add_row(name, *cells)
    return table


def lock_table(results: Results) -> PlainTable | None:
    """What the drives noticed of lost lock; None where nothing was lost and nothing alarmed."""
    entries = {n: p for n, p in results.policies.items() if not p["bound"]}
    if not any(p["lock_counts"]["lost"] or p["false_alarms_per_hour"] for p in entries.values()):
        return None
    caption = (
        "detected: alarm within 50 ms of the verdict, of scenarios that went on so long. after: "
        "median from verdict to alarm, negative where the alarm came first. recovered: back at "
        "angle and twin's speed (2 % of rated) 300 ms after the alarm, of those with time for it. "
        "false alarms: in scenarios that hold."
    )
    table = PlainTable(title="lost lock, as the drive itself saw it", caption=caption)
    table.add_column("policy", overflow="fold")
    for heading in (
        "lost",
        "detected\n[%]",
        "after\n[ms]",
        "recovered\n[%]",
        "false alarms\nan hour",
    ):
        table.add_column(heading, justify="right")
    for name, p in entries.items():
        table.add_row(
            name,
            str(p["lock_counts"]["lost"]),
            number(100.0 * p["detected_rate"], 1),
            number(p["detect_ms"], 0),
            number(100.0 * p["recovered_rate"], 1),
            number(p["false_alarms_per_hour"], 2),
        )
    return table


def kept(case: dict[str, Any]) -> str:
    """Say how a scenario that was not lost ended."""
    return "not held" if case["not_held"] else "–"


def paired_table(results: Results, columns: Columns = COLUMNS) -> PlainTable:
    """Differences to the first policy, scenario by scenario, with 95 % intervals."""
    first = next(iter(results.policies))
    caption = (
        "mean difference scenario by scenario (95 % interval), below it in percent of the first "
        "policy's mean; negative: less than the first. Rates over the feasible scenarios, others "
        "over those that both survive. Each policy counts against its own twin."
    )
    table = PlainTable(title=f"difference to {first}", caption=caption)
    table.add_column("policy", overflow="fold")
    for _, heading, _, _ in columns:
        table.add_column(heading, justify="right")
    for name, pair in results.paired.items():
        cells = (difference(pair, key, factor, digits) for key, _, factor, digits in columns)
        table.add_row(results.label(name), *cells)
    return table


def difference(pair: dict[str, Any], key: str, factor: float, decimals: int) -> str:
    """One paired difference, its interval, and its share of the first policy's mean, as lines."""
    low, high = (number(factor * x, decimals) for x in pair[f"{key}_ci"])
    lines = (number(factor * pair[key], decimals), f"{low} … {high}")
    return "\n".join(filter(None, (*lines, share(pair[key], pair["there"][key]))))


def share(difference: float, base: float) -> str:
    """Difference in percent of the base, with its sign; empty without a base."""
    if not math.isfinite(difference) or not abs(base) > 1e-12:
        return ""
    text = number(100.0 * difference / base, 0)
    return f"{'' if text.startswith('−') or text == '0' else '+'}{text} %"


def place_table(name: str, policy: dict[str, Any]) -> PlainTable:
    """Lost rate and errors of one policy by quadrant and by speed."""
    caption = (
        "place: where the twin was, the same drive with a position sensor. lost: share of the "
        "scenarios that came there and were lost there (95 % interval). Others: RMS torque "
        "deviation from the twin, torque ripple and angle error while survivors were there."
    )
    table = PlainTable(title=name, caption=caption)
    table.add_column("place", no_wrap=True)
    for heading in ("time\n[%]", "came", "lost\n[%]", *(c[1] for c in PLACE_COLUMNS)):
        table.add_column(heading, justify="right")
    quadrants, speeds = policy["by_quadrant"], policy["by_speed"]
    blocks = ((quadrants, quadrants["place"]), (speeds, speed_labels(speeds["from_rated_speed"])))
    for block, labels in blocks:
        for j, label in enumerate(labels):
            table.add_row(
                label,
                f"{100.0 * block['time_share'][j]:.1f}",
                str(block["came"][j]),
                rate(block["lost_rate"][j], block["lost_ci"][j]),
                *(number(k * block[key][j], digits) for key, _, k, digits in PLACE_COLUMNS),
                end_section=j == len(labels) - 1,
            )
    return table


def speed_labels(edges: tuple[float, ...]) -> list[str]:
    """Names for bins of speed from their lower edges over rated speed."""
    ends = [f"{100 * low:.0f}–{100 * high:.0f} %" for low, high in pairwise(edges)]
    return [f"speed {end}" for end in [*ends, f"above {100 * edges[-1]:.0f} %"]]


def rate(value: float, interval: tuple[float, float]) -> str:
    """Rate and interval in percent."""
    if not math.isfinite(value):
        return "–"
    low, high = (100.0 * x for x in interval)
    return f"{100.0 * value:.1f} ({low:.1f}–{high:.1f})"


def number(value: float, decimals: int) -> str:
    """Return the number, or a dash for none."""
    if not math.isfinite(value):
        return "–"
    return f"{round(value, decimals) + 0.0:.{decimals}f}".replace("-", "−")
