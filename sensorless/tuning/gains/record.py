"""What a tuning of gains leaves behind: the settings to use, and how they were found."""

import dataclasses
from importlib.metadata import version
from typing import Any

from sensorless.design.carried import chosen, record
from sensorless.design.drive import DriveDesign
from sensorless.design.words import text_of
from sensorless.evaluation.objective import OBJECTIVE
from sensorless.machine.motor import Motor
from sensorless.settings import settings_of
from sensorless.tuning.gains.choice import with_gains
from sensorless.tuning.gains.measure import KEPT
from sensorless.tuning.gains.search import ROLE, SUITES, Search
from sensorless.versions import versions

FORMAT = "sensorless-gains/1"


def words(design: DriveDesign) -> list[str]:
    """What ``--set`` takes for a design: all that is not a default."""
    known = settings_of(DriveDesign)
    values = dataclasses.asdict(design)
    return [
        f"{name}={text_of(values[name])}"
        for name in chosen(design)
        if values[name] != known[name].default
    ]


def record_of(
    motor: Motor, design: DriveDesign, policy: str, found: Search, size: int, seed: int
) -> dict[str, Any]:
    """All about a tuning in JSON types, but for command and verdict."""
    tuned = with_gains(design, found.best)
    return {
        "format": FORMAT,
        "motor": motor.name,
        "estimator": design.estimator,
        "policy": policy,
        "words": words(tuned),
        "start": {gain.name: gain.start for gain in found.gains},
        "tuned": found.best,
        "objective": {
            "text": OBJECTIVE,
            "start": found.start_value,
            "tuned": found.best_value,
        },
        "kept": ["not_held_rate", *KEPT],
        "suites": SUITES,
        "role": ROLE,
        "seed": seed,
        "scenarios_per_candidate": size,
        "population": found.population,
        "tried": found.tried,
        "interrupted": found.interrupted,
        "centres": [dataclasses.asdict(centre) for centre in found.centres],
        "provenance": record(tuned, motor),
        "versions": {**versions(), "cma": version("cma")},
    }
