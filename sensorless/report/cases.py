"""Chooses the scenarios of an evaluation that a report shows as waveforms."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from sensorless.envs.scenarios.suites import scenario_word
from sensorless.evaluation.results import Results
from sensorless.evaluation.results_tables import kept

MEASURE = "torque_p2p_handover"
"""Metric that picks the typical hand-over: the median among the survived ones."""
CROSSED = 1.0
"""Total variation of the weight above which a scenario counts as a hand-over."""
OURS, THEIRS = 5, 3
"""Worst cases shown of the policy, and of the one beside it."""


@dataclass(frozen=True)
class Case:
    """One scenario to look at."""

    what: str
    """why it is shown"""
    scenario: str
    """argument of ``simulate --scenario``"""
    end: str
    """lost and why, not held, or a dash"""
    time: float
    """lived [s]"""
    deviation: float
    """of the torque, over rated"""
    angle: float
    """largest error [deg]"""


def cases(results: Results, name: str, reference: str) -> list[Case]:
    """Worst cases of a policy and of the reference; typical and worst hand-over of the policy.

    Hand-overs come from the suite ``handoff`` alone; a policy that never moves its weight that much
    has none. No scenario is shown twice.
    """
    found = [
        _case(f"worst {j + 1} of {who}", worst)
        for who, count in ((name, OURS), (reference, THEIRS))
        for j, worst in enumerate(results.policies[who]["worst"][:count])
    ]
    if results.suite == "handoff":
        found += _hand_overs(results, name)
    out: dict[str, Case] = {}
    for case in found:
        out.setdefault(case.scenario, case)
    return list(out.values())


def _case(what: str, worst: Mapping[str, Any]) -> Case:
    where = f", {worst['quadrant']}" if worst["quadrant"] else ""
    end = f"{worst['lost_cause']}{where}" if worst["lost_cause"] else kept(dict(worst))
    values = (worst[key] for key in ("time_s", "torque_dev_rms", "angle_err_max_deg"))
    return Case(what, worst["scenario"], end, *values)


def _hand_overs(results: Results, name: str) -> list[Case]:
    rows = results.policies[name]["scenarios"]
    size, deviation, activity, time, angle = (
        np.array(rows[key], dtype=np.float64)
        for key in (MEASURE, "torque_dev_rms", "k_s_activity", "time_s", "angle_err_max_deg")
    )
    lost = np.array(rows["lost"])
    crossed = np.flatnonzero(np.isfinite(size) & ~lost & (activity * time >= CROSSED))
    if not len(crossed):
        return []
    order = crossed[np.argsort(size[crossed], kind="stable")]
    typical = int(order[(len(order) - 1) // 2])
    worst = int(crossed[np.argmax(deviation[crossed])])
    return [
        Case(
            f"{what} hand-over of {name}",
            scenario_word("handoff", results.seed, i, len(lost)),
            "–",
            float(time[i]),
            float(deviation[i]),
            float(angle[i]),
        )
        for what, i in (("typical", typical), ("worst survived", worst))
    ]
