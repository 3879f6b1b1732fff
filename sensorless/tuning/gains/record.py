"""What a tuning of gains leaves behind: the settings to use, and how they were found."""

import dataclasses
from typing import Any

from sensorless.design.carried import record
from sensorless.design.drive import DriveDesign
from sensorless.design.words import words_of
from sensorless.evaluation.objective import OBJECTIVE
from sensorless.machine.motor import Motor
from sensorless.tuning.gains.choice import with_gains
from sensorless.tuning.gains.measure import KEPT
from sensorless.tuning.gains.search import ROLE, SUITES, Search
from sensorless.versions import LIBRARIES, versions

FORMAT = "sensorless-gains/1"


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
        "words": words_of(tuned),
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
        "versions": versions((*LIBRARIES, "cma")),
    }
