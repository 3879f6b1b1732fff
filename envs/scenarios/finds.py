"""Scenarios that a search found: a suite, and the numbers to draw from it; on any machine."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.envs.counter_random import Chosen, Draws, Floats, Seeds
from sensorless.envs.scenarios.scenario import OF_THE_MACHINE, OF_THE_SCENARIO, Scenarios
from sensorless.envs.scenarios.stress import (
    low_inertia_scenarios,
    mismatch_scenarios,
    stress_1_scenarios,
    stress_scenarios,
)
from sensorless.errors import UserError
from sensorless.files import read_json
from sensorless.machine.motor import Motor

SEARCHED = {
    "stress": stress_scenarios,
    "stress-1": stress_1_scenarios,
    "mismatch": mismatch_scenarios,
    "low-inertia": low_inertia_scenarios,
}
"""Suites that can be searched."""
REMOVABLE = (
    *(name for name in (*OF_THE_MACHINE, *OF_THE_SCENARIO) if not name.startswith("ripple_")),
    "theta_err_0", "noise", "gain", "offset", "u_dc", "dead_time", "cross_hat", "psi_f", "R_s",
    "L_q_hat", "J", "tau",
)  # fmt: skip
"""Fields of ``Scenarios`` that minimising sets to nominal, in this order."""
HARD = Path(__file__).with_name("hard.json")
JITTER = 0.02
"""Half the range in which a suite moves the numbers of scenarios that it repeats."""

TUPLES = ("units", "nominal", "machine")
"""Fields that a file holds as lists."""
Units = dict[tuple[int, int], Floats]


@dataclass(frozen=True)
class Find:
    """One scenario that a policy loses, or nearly."""

    suite: str
    seed: int
    """of what is not searched: the noise of the sensors"""
    units: tuple[float, ...]
    """numbers in [0, 1) in the order in which the suite draws them"""
    severity: float
    """largest angle error [deg], or above 200 if lost, see ``sensorless.falsify.search``"""
    lost_at: float | None
    """[s]; None if lock was kept"""
    nominal: tuple[str, ...] = ()
    """fields of ``REMOVABLE`` that are not needed: it is lost with all of them nominal too"""
    machine: tuple[int, int] | None = None
    """seed and number of its machine in the suite ``machines``; None: that of the command"""


def keys(suite: str, motor: Motor) -> tuple[tuple[int, int], ...]:
    """Parts and columns of the numbers that a suite draws, in order."""
    source = Chosen(np.zeros(1, dtype=np.uint64))
    SEARCHED[suite](motor, source)
    return tuple(source.units)


def drawn(suite: str, motor: Motor, seeds: Seeds, units: Floats) -> Scenarios:
    """Scenarios of a suite from ``units`` (n, numbers).

    Raises
    ------
    UserError
        The suite draws another number of numbers.
    """
    names = keys(suite, motor)
    if units.shape[1] != len(names):
        raise UserError(
            f"scenario: {units.shape[1]} numbers, but {suite} draws {len(names)}; search again"
        )
    return SEARCHED[suite](motor, Chosen(seeds, dict(zip(names, units.T.copy(), strict=True))))


def without(s: Scenarios, names: Sequence[str], motor: Motor) -> Scenarios:
    """Copy in which some fields are nominal."""
    exact = Scenarios.nominal(motor, s.seed, 1.0)
    inertia = np.ones(len(s)) if "J" not in names else s.J
    changes = {name: getattr(exact, name) for name in names}
    return replace(s, **changes, omega_rate=s.omega_rate * inertia[:, None])


def scenarios_of(finds: Sequence[Find], motor: Motor) -> Scenarios:
    """Scenarios of finds, which are of one suite."""
    seeds = np.array([find.seed for find in finds], dtype=np.uint64)
    return drawn(finds[0].suite, motor, seeds, np.array([find.units for find in finds]))


def text_of(finds: Sequence[Find], facts: dict[str, Any]) -> str:
    """Text of a file: ``facts`` on the search, and the finds, one a line."""
    lines = ",\n".join(f"  {json.dumps(asdict(find))}" for find in finds)
    inner = json.dumps(facts, indent=1)[1:-1].rstrip()
    return "{" + inner + ',\n "finds": [\n' + lines + "\n ]\n}\n"


def load(path: Path) -> list[Find]:
    """Finds of a file.

    Raises
    ------
    UserError
        It is no such file.
    """
    try:
        data = read_json(path)["finds"]
        return [
            Find(**{**x, **{name: tuple(x[name]) for name in TUPLES if x.get(name) is not None}})
            for x in data
            if _plausible(**x)
        ]
    except OSError as error:
        raise UserError(f"scenario: {str(path)!r}: {error.strerror or error}") from None
    except (ValueError, KeyError, TypeError):
        raise UserError(
            f"scenario: {str(path)!r} is not a file of sensorless falsify; give one that it wrote"
        ) from None


def require_finds(out: Path) -> None:
    """Raise UserError if a file that a search would replace is of something else."""
    try:
        load(out)
    except UserError:
        raise UserError(
            f"out: {str(out)!r} is not a file of sensorless falsify; give another name"
        ) from None


def searched_on(path: Path) -> tuple[str, str]:
    """Names of motor and estimator of the search in a file that ``load`` reads; empty: unknown."""
    facts = json.loads(path.read_text(encoding="utf-8"))
    return str(facts.get("motor", "")), str(facts.get("estimator", ""))


def _plausible(
    suite: str,
    units: list[float],
    seed: int,
    machine: list[int] | None = None,
    nominal: Sequence[str] = (),
    **other: object,
) -> bool:
    """Return True where numbers and names are such, and a machine is a seed and an index; or raise.

    A number of a find is in [0, 1]: rounding may have carried one to 1.
    """
    del other
    pair = machine is None or len(machine) == 2
    whole = all(isinstance(x, int) and 0 <= x < 2**64 for x in (seed, *(machine or ())))
    known = suite in SEARCHED and set(nominal) <= set(REMOVABLE)
    if not (pair and whole and known and all(0.0 <= u <= 1.0 for u in units)):
        raise ValueError
    return True


def hard_scenarios(motor: Motor, seeds: Seeds, indices: NDArray[np.int64], half: int) -> Scenarios:
    """Every second shipped find, from ``half``, with other noise; moved where they repeat."""
    finds = load(HARD)[half::2]
    rows = [finds[i % len(finds)] for i in indices]
    units = np.array([find.units for find in rows])
    d = Draws(seeds)
    move = np.stack([d.uniform(-JITTER, JITTER) for _ in range(units.shape[1])], axis=-1)
    again = (indices >= len(finds))[:, None]
    units = np.where(again, np.clip(units + move, 0.0, 1.0 - 1e-9), units)
    return drawn(rows[0].suite, motor, d.seeds, units)
