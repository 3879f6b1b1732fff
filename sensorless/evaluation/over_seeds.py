"""Several schedules of one kind, one per seed, against one other: changes with intervals."""

import math
from collections.abc import Sequence

import numpy as np

from sensorless.evaluation.evaluate import Scores
from sensorless.evaluation.rollout import are_feasible

RESAMPLES = 1000


def survived(s: Scores, names: Sequence[str]) -> dict[str, float]:
    """Lost scenarios ``of`` the feasible ones, and means of metrics over the survived ones."""
    kept, feasible = s.lost == 0, are_feasible(s.lost)
    means = {n: round(float(np.nanmean(s.metrics[n][kept])), 5) for n in names}
    return {"lost": int(np.sum(~kept & feasible)), "of": int(np.sum(feasible)), **means}


def change_over_seeds(ours: Sequence[Scores], theirs: Scores, name: str) -> dict[str, float]:
    """Change of a mean [%], ours over theirs, with its 95 % interval over seeds and scenarios.

    Means are over the scenarios that both survived and in which both have the metric.
    """
    there = theirs.metrics[name]
    both = [(s.lost == 0) & (theirs.lost == 0) & np.isfinite(there) for s in ours]
    both = [b & np.isfinite(s.metrics[name]) for b, s in zip(both, ours, strict=True)]
    a = np.array([np.where(b, s.metrics[name], 0.0) for b, s in zip(both, ours, strict=True)])
    b = np.array([np.where(b, there, 0.0) for b in both])
    rng = np.random.default_rng(len(there))
    counts = rng.multinomial(len(there), np.full(len(there), 1.0 / len(there)), RESAMPLES)
    with np.errstate(all="ignore"):  # where the other has none of it, the change is no number
        by_scenarios = (counts @ a.sum(axis=0)) / (counts @ b.sum(axis=0))
        change = float(a.sum() / b.sum()) - 1.0
        half = half_width(a.sum(axis=1) / b.sum(axis=1), float(by_scenarios.std()), len(there))
    return {k: round(100.0 * x, 2) for k, x in
            {"change": change, "low": change - half, "high": change + half}.items()}  # fmt: skip


def half_width(by_seed: Sequence[float], of_scenarios: float, n: int) -> float:
    """Half of a 95 % interval of a mean over seeds that all ran the same n scenarios.

    Student's t of the standard errors over seeds and over scenarios together, with Welch's and
    Satterthwaite's degrees of freedom (doi 10.2307/3002019): resampling a few seeds makes intervals
    that hold in 71 % of the cases with three, and in 84 % with five.

    Parameters
    ----------
    by_seed : value of each seed
    of_scenarios : standard error by the choice of scenarios
    """
    from scipy.stats import t

    k = len(by_seed)
    parts = [(of_scenarios**2, n - 1)]
    if k > 1:
        parts.append((float(np.var(by_seed, ddof=1)) / k, k - 1))
    total = sum(x for x, _ in parts)
    if total == 0.0:
        return 0.0
    freedom = total**2 / sum(x**2 / df for x, df in parts)
    return float(t.ppf(0.975, freedom)) * math.sqrt(total)
