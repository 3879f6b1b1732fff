"""Chooses the scenarios of an evaluation that a report shows as waveforms."""

from dataclasses import dataclass

import numpy as np

from sensorless.envs.scenarios.suites import scenario_word
from sensorless.evaluation.results import Results

MEASURE = "torque_p2p_handover"
"""Metric that picks the typical hand-over: the median among the survived ones."""
CROSSED = 1.0
"""Total variation of the weight above which a scenario counts as a hand-over."""


@dataclass(frozen=True)
class Case:
    """One scenario to look at."""

    key: str
    """name of its figure"""
    title: str
    scenario: str
    """argument of ``simulate --scenario``"""


def cases(results: Results, name: str, reference: str) -> list[Case]:
    """Typical and worst hand-over of a policy, its worst case, and the worst case of the reference.

    Hand-overs come from the suite ``handoff`` alone; a policy that never moves its weight that much
    has none. No scenario is shown twice.
    """
    found: list[tuple[str, str, str]] = []
    if results.suite == "handoff":
        found = _hand_overs(results, name)
    found += [
        (f"worst-{who}", f"Worst case of {who}", results.policies[who]["worst"][0]["scenario"])
        for who in (name, reference)
    ]
    out: dict[str, Case] = {}
    for key, title, word in found:
        out.setdefault(word, Case(f"{results.suite}-{key}", title, word))
    return list(out.values())


def _hand_overs(results: Results, name: str) -> list[tuple[str, str, str]]:
    rows = results.policies[name]["scenarios"]
    size, deviation, activity, time = (
        np.array(rows[key], dtype=np.float64)
        for key in (MEASURE, "torque_dev_rms", "k_s_activity", "time_s")
    )
    lost = np.array(rows["lost"])
    crossed = np.flatnonzero(np.isfinite(size) & ~lost & (activity * time >= CROSSED))
    if not len(crossed):
        return []
    order = crossed[np.argsort(size[crossed], kind="stable")]
    typical = int(order[(len(order) - 1) // 2])
    worst = int(crossed[np.argmax(deviation[crossed])])
    return [
        (key, f"{title} hand-over of {name}", scenario_word("handoff", results.seed, i, len(lost)))
        for key, title, i in (("typical", "Typical", typical), ("worst", "Worst survived", worst))
    ]
