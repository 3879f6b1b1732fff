"""What a schedule is trained and tuned for, in one number."""

from dataclasses import dataclass

LOST_WEIGHT = 10.0
OBJECTIVE = (
    f"{LOST_WEIGHT:g} lost_rate + mean torque_dev_rms + mean torque_ripple_rms "
    "(means over the scenarios survived, shares of rated torque)"
)
"""What training and tuning make least: one scenario more lost in 1000 weighs like 1 % of torque."""


@dataclass(frozen=True)
class Cost:
    """One policy on a set of scenarios."""

    lost_rate: float
    torque_dev: float
    """Mean ``torque_dev_rms`` of the scenarios survived; 1 if there is none."""
    torque_ripple: float
    """Mean ``torque_ripple_rms`` of the same."""

    @property
    def objective(self) -> float:
        """Return the value of ``OBJECTIVE``."""
        return LOST_WEIGHT * self.lost_rate + self.torque_dev + self.torque_ripple
