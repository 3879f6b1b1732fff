"""Which scenarios of an evaluation a report shows as waveforms."""

from dataclasses import dataclass

import numpy as np

from sensorless.results import Results
from sensorless.suites import scenario_word

MEASURE = "torque_p2p_handover"
"""What makes a hand-over a typical one: the median of it among those survived."""


@dataclass(frozen=True)
class Case:
    """One scenario to look at."""

    key: str
    """Name of its figure."""
    title: str
    scenario: str
    """Word for ``simulate --scenario``."""


def cases(results: Results, name: str, reference: str) -> list[Case]:
    """Typical and worst scenario under a policy, and the worst under the one to compare with."""
    found = [("typical", f"Typical hand-over of {name}", _typical(results, name))]
    found += [
        (f"worst-{who}", f"Worst case of {who}", results.policies[who]["worst"][0]["scenario"])
        for who in (name, reference)
    ]
    out: dict[str, Case] = {}
    for key, title, word in found:
        if word is not None and word not in out:
            out[word] = Case(f"{results.suite}-{key}", title, word)
    return list(out.values())


def _typical(results: Results, name: str) -> str | None:
    """The scenario survived whose hand-over is the median one; None without any hand-over."""
    rows = results.policies[name]["scenarios"]
    measure = np.array(rows[MEASURE], dtype=np.float64)
    known = np.flatnonzero(np.isfinite(measure) & ~np.array(rows["lost"]))
    if not len(known):
        return None
    order = known[np.argsort(measure[known], kind="stable")]
    index = int(order[(len(order) - 1) // 2])
    return scenario_word(results.suite, results.seed, index, results.size)
