"""From numbers per scenario to rates, means and paired differences, with their intervals.

Scenarios that resemble each other, say those on one machine, tell less than as many independent
ones. ``groups`` says which belong together; intervals then resample groups.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import Array
from sensorless.evaluation.rates import (
    Bools,
    Groups,
    Interval,
    difference_interval,
    mean,
    rate_interval,
)
from sensorless.evaluation.rollout import CAUSES, Floats, are_feasible

RESAMPLES = 2000
"""Bootstrap samples of an interval."""

Rows = NDArray[np.intp]


def mean_interval(x: Floats, seed: int, groups: Groups | None = None) -> Interval:
    """95 % percentile bootstrap interval of the mean; NaN for fewer than two values or groups.

    The same ``seed`` draws the same samples, so an interval does not depend on earlier ones.
    """
    if groups is None:
        return _interval(x, np.mean, seed)
    count, total = np.bincount(groups), np.bincount(groups, x)
    total, count = total[count > 0], count[count > 0]
    return interval_of(lambda of: total[of].sum(-1) / count[of].sum(-1), len(count), seed)


def interval_of(statistic: Callable[[Rows], Floats], n: int, seed: int) -> Interval:
    """The same of any statistic of n scenarios.

    ``statistic`` gives its values (m,) over draws of scenarios (m, n), by their numbers.
    """
    return _interval(np.arange(n), lambda rows, axis: statistic(rows), seed)


def _interval(x: Floats | Rows, statistic: Callable[..., Any], seed: int) -> Interval:
    if len(x) < 2:
        return math.nan, math.nan
    from scipy.stats import bootstrap

    result = bootstrap(
        (x,),
        statistic,
        vectorized=True,
        n_resamples=RESAMPLES,
        method="percentile",
        batch=max(1, 4_000_000 // len(x)),
        random_state=np.random.default_rng(seed),
    )
    return float(result.confidence_interval.low), float(result.confidence_interval.high)


def mean_of(
    values: Mapping[str, Floats], rows: Bools, seed: int, groups: Groups | None = None
) -> dict[str, Any]:
    """Mean over ``rows``, interval and number of defined values of each metric.

    The keys are ``NAME`` and ``NAME_ci``, and ``defined`` with the numbers by name. A metric leaves
    out scenarios in which it is NaN; if it is defined nowhere, its mean is NaN.
    """
    out: dict[str, Any] = {}
    defined = {}
    for name, x in values.items():
        there = rows & np.isfinite(x)
        known = x[there]
        out[name] = float(np.mean(known, dtype=np.float64)) if len(known) else math.nan
        out[f"{name}_ci"] = mean_interval(known, seed, _of(groups, there))
        defined[name] = len(known)
    return {**out, "defined": defined}


def _of(groups: Groups | None, rows: Bools) -> Groups | None:
    return None if groups is None else groups[rows]


def summary(
    lost: NDArray[np.int32],
    metrics: Mapping[str, Floats],
    seed: int,
    groups: Groups | None = None,
) -> dict[str, Any]:
    """Lost and not-held rates over the feasible scenarios, means of ``metrics`` over survivors.

    A scenario is not feasible if its sensored twin, the same drive with the true angle, trips or
    runs away: it is beyond the machine, so no policy loses or holds it.

    Parameters
    ----------
    lost : (n,) bits of ``CAUSES``
    """
    survived, feasible = lost == 0, are_feasible(lost)
    out = {
        "lost_rate": mean(~survived[feasible]),
        "lost_ci": rate_interval(~survived[feasible], _of(groups, feasible)),
        "infeasible_rate": float(np.mean(~feasible)),
        "lost_by_cause": {name: int(np.sum(lost & bit != 0)) for name, bit in CAUSES.items()},
    }
    if "not_held" in metrics:
        loose = _not_held(lost, metrics)[feasible]
        out |= {
            "not_held_rate": mean(loose),
            "not_held_rate_ci": rate_interval(loose > 0.0, _of(groups, feasible)),
        }
    return {**out, "survived": int(survived.sum()), **mean_of(metrics, survived, seed, groups)}


def _not_held(lost: NDArray[np.int32], metrics: Mapping[str, Floats]) -> Floats:
    """(n,) 1 where the drive kept lock but did not hold its speed."""
    return np.asarray(np.where(lost == 0, metrics["not_held"], 0.0))


def paired(
    lost: NDArray[np.int32],
    metrics: Mapping[str, Floats],
    reference_lost: NDArray[np.int32],
    reference: Mapping[str, Floats],
    seed: int,
    groups: Groups | None = None,
) -> dict[str, Any]:
    """Differences to a reference, scenario by scenario; negative if this policy has less.

    Lost and not-held rates over the feasible scenarios, see ``summary``; ``metrics`` over those
    that both survived; ``there`` has the means of the reference over the same scenarios.
    """
    feasible = are_feasible(lost | reference_lost)
    here, there = (lost != 0) & feasible, (reference_lost != 0) & feasible
    both = (lost | reference_lost) == 0
    rates = {"lost_rate": (here, there)}
    if "not_held" in metrics:
        loose, reference_loose = _not_held(lost, metrics), _not_held(reference_lost, reference)
        rates["not_held_rate"] = loose > 0.0, reference_loose > 0.0
    rates = {name: (x[feasible], y[feasible]) for name, (x, y) in rates.items()}
    apart = {name: x - reference[name] for name, x in metrics.items()}
    base = {name: reference[name][both & np.isfinite(x)] for name, x in apart.items()}
    return {
        "survived_both": int(both.sum()),
        "lost_only_here": int(np.sum(here & ~there)),
        "lost_only_there": int(np.sum(there & ~here)),
        **{name: mean(x) - mean(y) for name, (x, y) in rates.items()},
        **{
            f"{name}_ci": difference_interval(x, y, _of(groups, feasible))
            for name, (x, y) in rates.items()
        },
        **mean_of(apart, both, seed, groups),
        "there": {
            **{name: mean(y) for name, (_, y) in rates.items()},
            **{name: mean(x) for name, x in base.items()},
        },
    }


def by_place(places: Array, survived: Bools, groups: Groups | None = None) -> dict[str, list[Any]]:
    """Lost rate and errors in each of p places, lists of p.

    ``came`` counts the scenarios that were in the place, ``lost`` those lost there, with rate and
    Wilson interval (NaN if none came). ``time_share`` and errors are over the survived scenarios,
    errors as RMS over their time in the place.

    Parameters
    ----------
    places : (n, p) of ``metrics.place.PLACE``
    survived : (n,)
    """
    came, lost = (places["periods"] > 0), places["lost"]
    kept = places[survived]
    count = kept["periods"].sum(axis=0)
    known = np.where(count > 0, count, np.nan)

    def rms(name: str) -> Floats:
        return np.asarray(np.sqrt(np.maximum(kept[name].sum(axis=0), 0.0) / known))

    return {
        "came": came.sum(axis=0).tolist(),
        "lost": lost.sum(axis=0).tolist(),
        "lost_rate": [
            float(np.mean(x[c])) if c.any() else math.nan for x, c in _columns(lost, came)
        ],
        "lost_ci": [
            rate_interval(x[c], _of(groups, c)) if c.any() else (math.nan, math.nan)
            for x, c in _columns(lost, came)
        ],
        "time_share": (count / max(int(count.sum()), 1)).tolist(),
        "angle_err_rms_deg": np.rad2deg(rms("err_sq")).tolist(),
        "torque_dev_rms": rms("dev_sq").tolist(),
        "torque_ripple_rms": rms("ripple_sq").tolist(),
    }


def _columns(*arrays: Bools) -> Iterator[tuple[Bools, ...]]:
    return zip(*(x.T for x in arrays), strict=True)


def worst(
    lost: NDArray[np.int32], time: Floats, not_held: Floats, deviation: Floats, count: int
) -> list[int]:
    """Indices of the ``count`` worst scenarios, worst first.

    Lost ones come first, the earliest first; then those not held, then the other survivors, each by
    ``deviation``, the largest first; last those that are not feasible, see ``summary``.

    Parameters
    ----------
    lost : (n,) bits of ``CAUSES``
    time : (n,) time lived [s]
    not_held : (n,) 1 or 0
    deviation : (n,)
    """
    group = np.where(lost == 0, np.where(not_held > 0.0, 1, 2), np.where(are_feasible(lost), 0, 3))
    within = np.where(lost == 0, -np.nan_to_num(deviation), time)
    return [int(i) for i in np.lexsort((within, group))[:count]]
