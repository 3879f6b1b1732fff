"""What a check finds, how much each finding weighs, and the verdict."""

from collections.abc import Sequence
from dataclasses import dataclass

NOTE, LIMIT, NO = "note", "limit", "no"
"""Good to know; the drive runs with a limit; the drive does not run."""


@dataclass(frozen=True)
class Finding:
    """One sentence about a machine."""

    weight: str
    """``NOTE``, ``LIMIT`` or ``NO``"""
    field: str
    """field of the motor file that it concerns, or part of the check"""
    text: str


@dataclass(frozen=True)
class Verdict:
    """Whether a machine is suitable (yes, with limits, no), and why."""

    word: str
    because: tuple[str, ...]

    @property
    def head(self) -> str:
        """How the last sentence of a check begins; the reasons follow."""
        return f"suitable: {self.word}" + (", because" if self.because else "")

    def __str__(self) -> str:
        """Return the last sentence of a check."""
        return " ".join(filter(None, (self.head, "; ".join(self.because))))


def verdict(findings: Sequence[Finding]) -> Verdict:
    """Verdict of all findings: the heaviest decide, and all but notes are the reasons.

    What limits a machine may be why it fails, so a *no* has the limits too, after its own.
    """
    no, limits = (tuple(f.text for f in findings if f.weight == w) for w in (NO, LIMIT))
    return Verdict("no" if no else "with limits" if limits else "yes", (*no, *limits))
