"""What a schedule is trained or tuned on: one machine, or random ones."""

from dataclasses import dataclass
from typing import Any

from sensorless.envs.scenarios.machine_family import NAME, family, family_digest
from sensorless.errors import UserError
from sensorless.machine.motor import Motor

JUDGED = 1_000_000
"""Added to the seed of machines to judge on; training and tuning draw theirs from those below."""


@dataclass(frozen=True)
class Machines:
    """One machine, or some of a family."""

    motors: tuple[Motor, ...]
    seed: int | None
    """Seed of the family; None for a single machine."""

    @classmethod
    def of(cls, motor: Motor, n: int, seed: int) -> "Machines":
        """Return n random machines of a seed to train or tune on, or the motor if n is 0.

        Errors as in ``family``, and where the suite ``machines`` may judge on the same ones.
        """
        if n and seed >= JUDGED:
            raise UserError(
                f"seed: {seed}; with random machines give less than {JUDGED}: the suite machines "
                "judges on those of seeds from there on"
            )
        return cls(family(seed, n), seed) if n else cls((motor,), None)

    @property
    def one(self) -> Motor | None:
        """The machine, if it is no family."""
        return self.motors[0] if self.seed is None else None

    @property
    def name(self) -> str:
        """Name for people."""
        if self.seed is None:
            return self.motors[0].name
        return f"{len(self.motors)} machines of {NAME}, seed {self.seed}"

    @property
    def digest(self) -> str:
        """SHA-256 over all their numbers, hexadecimal."""
        return self.motors[0].digest if self.seed is None else family_digest(self.motors)

    def origin(self) -> dict[str, Any]:
        """What a schedule records about them; one from several machines names no motor digest."""
        if self.seed is None:
            return {"motor": self.name, "motor_digest": self.digest}
        facts = {"family": NAME, "seed": self.seed, "n": len(self.motors), "digest": self.digest}
        return {"motor": self.name, "machines": facts}
