"""What was counted of a suite: how many scenarios were lost and not held, and its file."""

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from scipy.stats import binomtest

from sensorless.envs.scenarios.suites import scenario_word
from sensorless.errors import UserError
from sensorless.files import read_json, write_atomic

LISTED = 100
"""Lost scenarios, and as many that are not held, that the file names."""


@dataclass(frozen=True)
class Tally:
    """Scenarios counted so far."""

    scenarios: int = 0
    infeasible: int = 0
    """those that the sensored twin fails"""
    lost: int = 0
    not_held: int = 0
    """kept lock, but not the speed"""
    lost_at: tuple[int, ...] = ()
    """indices of the first ``LISTED``"""
    not_held_at: tuple[int, ...] = ()

    def __add__(self, other: "Tally") -> "Tally":
        """Both, ``other`` being of later scenarios."""
        mine, more = asdict(self), asdict(other)
        both = {name: mine[name] + more[name] for name in mine}
        lists = {name: x[:LISTED] for name, x in both.items() if isinstance(x, tuple)}
        return Tally(**{**both, **lists})


def exact_interval(hits: int, of: int) -> tuple[float, float]:
    """95 % interval of a rate by Clopper and Pearson, doi 10.1093/biomet/26.4.404."""
    if of == 0:
        return 0.0, 1.0
    interval = binomtest(hits, of).proportion_ci(confidence_level=0.95, method="exact")
    return float(interval.low), float(interval.high)


def read_tally(out: Path, run: dict[str, Any]) -> Tally:
    """Tally of an earlier file.

    Raises
    ------
    UserError
        It is no such file, or of another run.
    """
    try:
        known = read_json(out)
        tally = Tally(**known["tally"])
        done = replace(tally, lost_at=tuple(tally.lost_at), not_held_at=tuple(tally.not_held_at))
        _check(done)
    except (OSError, ValueError, KeyError, TypeError):
        raise UserError(
            f"out: {str(out)!r} is not a file of sensorless certify; give another file"
        ) from None
    for name, value in json.loads(json.dumps(run)).items():
        if known.get(name) != value:
            raise UserError(
                f"out: {str(out)!r} is of another {name}; remove it, or give another file"
            )
    return done


def _check(tally: Tally) -> None:
    """Raise ValueError if numbers of a tally are no counts, or contradict each other."""
    counts = (tally.scenarios, tally.infeasible, tally.lost, tally.not_held)
    listed = (*tally.lost_at, *tally.not_held_at)
    if not all(type(x) is int and x >= 0 for x in (*counts, *listed)):
        raise ValueError
    places = ((tally.lost, tally.lost_at), (tally.not_held, tally.not_held_at))
    missing = any(len(at) != min(count, LISTED) for count, at in places)
    beyond = any(x >= tally.scenarios for x in listed)
    mixed = any(list(at) != sorted(set(at)) for _, at in places)
    if sum(counts[1:]) > tally.scenarios or missing or beyond or mixed:
        raise ValueError


def result(run: dict[str, Any], tally: Tally) -> dict[str, Any]:
    """Content of the file."""
    feasible = tally.scenarios - tally.infeasible
    suite, seed = run["suite"].split()[0], run["seed"]

    def words(indices: tuple[int, ...]) -> list[str]:
        size = int(run["suite"].split()[-1]) if suite == "envelope" else tally.scenarios
        return [scenario_word(suite, seed, i, size) for i in indices]

    return {
        "scenarios": tally.scenarios,
        "infeasible": tally.infeasible,
        "lost": tally.lost,
        "lost_ci": exact_interval(tally.lost, feasible),
        "not_held": tally.not_held,
        "not_held_ci": exact_interval(tally.not_held, feasible),
        "first_lost": words(tally.lost_at),
        "first_not_held": words(tally.not_held_at),
        **run,
        "tally": asdict(tally),
    }


def write(out: Path, run: dict[str, Any], tally: Tally) -> None:
    """Write the file as a whole or not at all; errors as ``write_atomic``."""
    write_atomic(out, json.dumps(result(run, tally), indent=1, allow_nan=False) + "\n")
