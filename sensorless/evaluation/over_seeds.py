"""Several schedules of one kind, one per seed, against one other: changes with intervals."""

from collections.abc import Sequence

import numpy as np

from sensorless.evaluation.evaluate import Scores

RESAMPLES = 1000


def survived(s: Scores, names: Sequence[str]) -> dict[str, float]:
    """Lost scenarios, and means of metrics over the survived ones."""
    kept = s.lost == 0
    means = {n: round(float(np.nanmean(s.metrics[n][kept])), 5) for n in names}
    return {"lost": int(np.sum(~kept)), "of": len(kept), **means}


def contrast(ours: Sequence[Scores], theirs: Scores, name: str) -> dict[str, float]:
    """Change of a mean [%], ours over theirs, with its 95 % interval over seeds and scenarios.

    Means are over the scenarios that both survived; an interval resamples seeds and scenarios.
    """
    there = theirs.metrics[name]
    both = [(s.lost == 0) & (theirs.lost == 0) & np.isfinite(there) for s in ours]
    both = [b & np.isfinite(s.metrics[name]) for b, s in zip(both, ours, strict=True)]
    a = np.array([np.where(b, s.metrics[name], 0.0) for b, s in zip(both, ours, strict=True)])
    b = np.array([np.where(b, there, 0.0) for b in both])
    rng = np.random.default_rng(len(there))
    counts = rng.multinomial(len(there), np.full(len(there), 1.0 / len(there)), RESAMPLES)
    seeds = rng.integers(len(ours), size=(RESAMPLES, len(ours)))
    top, bottom = (np.take_along_axis(counts @ x.T, seeds, axis=1).sum(axis=1) for x in (a, b))
    low, high = np.percentile(top / bottom, (2.5, 97.5))
    change = float(a.sum() / b.sum())
    return {k: round(100.0 * (x - 1.0), 2) for k, x in
            {"change": change, "low": float(low), "high": float(high)}.items()}  # fmt: skip
