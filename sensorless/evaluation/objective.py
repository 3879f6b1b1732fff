"""The objective of training and tuning: one number for a policy on a set of scenarios."""

from dataclasses import dataclass

LOST_WEIGHT = 10.0
OBJECTIVE = (
    f"{LOST_WEIGHT:g} lost_rate + mean torque_dev_rms + mean torque_ripple_rms "
    "(means over the scenarios survived, shares of rated torque)"
)
"""What training and tuning minimise: losing 1 scenario in 1000 more weighs like 1 % of torque."""


@dataclass(frozen=True)
class Cost:
    """One policy on a set of scenarios."""

    lost_rate: float
    torque_dev: float
    """Mean ``torque_dev_rms`` of the survived scenarios; 1 if there are none."""
    torque_ripple: float
    """Mean ``torque_ripple_rms`` of the same scenarios."""

    @property
    def objective(self) -> float:
        """Return the value of ``OBJECTIVE``."""
        return self.weighted(1.0)

    def weighted(self, ripple: float) -> float:
        """Return the objective with this weight of the ripple."""
        return LOST_WEIGHT * self.lost_rate + self.torque_dev + ripple * self.torque_ripple
