"""Frozen suites: what the leaderboard is judged on. Their scenarios may never change.

A digest over all numbers of all scenarios holds them; change a suite under another name.
"""

import dataclasses
import hashlib
from dataclasses import dataclass

import numpy as np

from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.suites import SuiteRows
from sensorless.machine.motor import Motor

MOTOR = "paper"
"""Machine of all of them."""
SEED = 11


@dataclass(frozen=True)
class Frozen:
    """One suite of ``MOTOR`` and ``SEED``."""

    suite: str
    size: int
    digest: str
    """``digest`` of its scenarios."""

    def rows(self, motor: Motor) -> SuiteRows:
        """Scenarios, not drawn yet."""
        return SuiteRows(self.suite, motor, SEED, self.size)


FROZEN = (
    Frozen("stress-1", 2000, "efc3724ab7b3fa52"),
    Frozen("stress", 2000, "0e8dbc030f1e3190"),
    Frozen("mismatch", 1000, "95b0c0bd81225cd0"),
    Frozen("low-inertia", 1000, "578f42c1e1db130c"),
    Frozen("hard", 512, "23034a4f9f4118cc"),
    Frozen("handoff", 520, "487fe9b5a0286677"),
)
"""The first one orders the leaderboard."""


def digest(s: Scenarios) -> str:
    """SHA-256 over the numbers of all fields, hexadecimal, first 16 digits.

    Numbers count as float32, as the drive takes them: processors may differ in the last bit of a
    double.
    """
    sha = hashlib.sha256()
    for field in dataclasses.fields(s):
        x = np.asarray(getattr(s, field.name))
        kept = x.astype("<u8") if x.dtype.kind == "u" else x.astype("<f4")
        sha.update(f"{field.name}{x.shape}".encode() + np.ascontiguousarray(kept).tobytes())
    return sha.hexdigest()[:16]
