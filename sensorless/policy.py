"""Policies: what chooses the weight k_s at every decision."""

import dataclasses
from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from sensorless.core.api import Array
from sensorless.design.drive import DriveDesign
from sensorless.table.ks_table import KsTable

Signals = NDArray[np.float32]

UNRECORDED = "smo"
"""Estimator of a schedule or tuned rule whose file names none: such files are older than the choice
of estimators."""


class Policy(Protocol):
    """Chooses k_s for n drives at once; row i of every array belongs to drive i."""

    name: str
    sensored: bool
    """Whether the drive runs on its true angle; k_s then has no effect."""
    estimator: str | None
    """Estimator that the policy needs, as in ``DriveDesign``; it overrides the design's. None: the
    policy runs on the design's."""

    def reset(self, n: int) -> None:
        """Forget the past before n drives start."""

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights wanted (n,), 0 to 1, at the signals (n, SIGNAL_N) of ``core/drive/signals.h``."""


@runtime_checkable
class PrivilegedPolicy(Policy, Protocol):
    """An upper bound, not a rule for a drive: it sees what no firmware can."""

    privileged: bool

    def act_knowing(self, obs: Signals, sims: Array) -> NDArray[np.float32]:
        """Weights wanted (n,) from the signals and the state of the simulated drives (SIM)."""


def design_for(policy: Policy, design: DriveDesign) -> DriveDesign:
    """Design with the estimator that the policy needs, if it needs one."""
    return dataclasses.replace(design, estimator=policy.estimator or design.estimator)


def trained_estimator(provenance: Mapping[str, Any]) -> str | None:
    """Estimator that a schedule was made on; None if its provenance does not name one."""
    design = provenance.get("design")
    return design.get("estimator") if isinstance(design, dict) else None


def decide(policy: Policy, obs: Signals, sims: Array) -> NDArray[np.float32]:
    """Weights wanted (n,); only a privileged policy sees the simulated drives."""
    knowing = getattr(
        policy, "act_knowing", None
    )  # a protocol's isinstance takes 100 times as long
    chosen: NDArray[np.float32] = policy.act(obs) if knowing is None else knowing(obs, sims)
    return chosen


class TablePolicy:
    """A schedule table, looked up by the code that runs on the target. It has no memory.

    Parameters
    ----------
    name : str
    table : KsTable
    estimator : str, optional
        See ``Policy``.
    """

    sensored = False

    def __init__(self, name: str, table: KsTable, estimator: str | None = None) -> None:
        self.name = name
        self.table = table
        self.estimator = estimator

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Interpolated weights (n,)."""
        return self.table.evaluate(obs)
