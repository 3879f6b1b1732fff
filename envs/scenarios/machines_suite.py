"""The suite ``machines``: random machines, each with some scenarios of ``stress-1``.

Machine i has the rows from ``SCENARIOS`` times i on.
"""

import re

from sensorless.envs.counter_random import LARGEST, check_seed
from sensorless.envs.scenarios.machine_family import family, member
from sensorless.envs.scenarios.machines import JUDGED, Machines
from sensorless.envs.scenarios.suites import MOST_SCENARIOS, SuiteRows, scenario_word
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

NAME, EACH = "machines", "stress-1"
"""The suite, and the one whose scenarios every machine runs."""
SCENARIOS = 16
"""Scenarios of a machine: one block of the core."""


def judged(seed: int, n: int) -> Machines:
    """Return the n machines of a seed; errors as in ``family``."""
    check_seed(seed, LARGEST - JUDGED)
    return Machines(family(JUDGED + seed, n), JUDGED + seed)


def machine(seed: int, i: int) -> Motor:
    """Return machine i of a seed; errors as in ``check_seed``."""
    check_seed(seed, LARGEST - JUDGED)
    return member(JUDGED + seed, i)


def refuse_motor(suite: str, motor: str | None) -> None:
    """Raise UserError where a machine is given to the suite that draws its own."""
    if suite == NAME and motor is not None:
        raise UserError(f"motor: {motor!r}: the suite {NAME} draws its own; leave out --motor")


def rows_on(motor: Motor, i: int, seed: int, n: int) -> SuiteRows:
    """Scenarios of machine i of n."""
    first = SCENARIOS * i
    return SuiteRows(EACH, motor, seed, SCENARIOS * n)[first : first + SCENARIOS]


def is_on_machines(word: str) -> bool:
    """Whether a word names a scenario of this suite."""
    return word.startswith(f"{NAME}:")


def on_machine(word: str) -> tuple[Motor, str]:
    """Machine of ``machines:SEED:INDEX``, and the word of its scenario for that machine.

    Raises
    ------
    UserError
        The word has another form, or its seed or index is too large.
    """
    found = re.fullmatch(rf"{NAME}:(\d+):(\d+)", word)
    if found is None:
        raise UserError(f"scenario: {word!r} cannot be read; write {NAME}:SEED:INDEX")
    seed, index = int(found[1]), int(found[2])
    if index >= MOST_SCENARIOS:
        raise UserError(f"scenario: {word!r}; give an INDEX below {MOST_SCENARIOS}")
    return machine(seed, index // SCENARIOS), scenario_word(EACH, seed, index, index + 1)
