"""Policies: what chooses the weight k_s, and gains of the drive, at every decision."""

import dataclasses
from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sensorless.core.api import Array
from sensorless.core.gains import GAIN_N, Gain, Values, write_wanted
from sensorless.design.drive import DriveDesign
from sensorless.errors import UserError
from sensorless.table.ks_table import KsTable

Signals = NDArray[np.float32]

Settings = Mapping[str, Any]
"""Settings of ``DriveDesign`` by name."""
NO_SETTINGS: Settings = {}

ROUNDING = 1e-5
"""How far an answer of a policy may lie beyond its range; it is clipped."""


class Policy(Protocol):
    """Chooses k_s for n drives at once; row i of every array belongs to drive i."""

    name: str
    sensored: bool
    """Whether the drive runs on its true angle; k_s then has no effect."""
    settings: Settings
    """What the policy needs of the drive; it overrides the design. A trained or tuned policy brings
    every setting that it was made on, a rule by name none, or the estimator that it is about."""

    def reset(self, n: int) -> None:
        """Forget the past before n drives start."""

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights wanted (n,), 0 to 1, at the signals (n, SIGNAL_N) of ``core/drive/signals.h``."""


@runtime_checkable
class PacedPolicy(Policy, Protocol):
    """A policy whose memory counts time; it is made for ``decision.RUNNING``."""

    def follow(self, decision: float) -> None:
        """Decide at another interval [s]."""


@runtime_checkable
class PrivilegedPolicy(Policy, Protocol):
    """An upper bound, not a rule for a drive: it sees what no firmware can."""

    def act_knowing(self, obs: Signals, sims: Array) -> NDArray[np.float32]:
        """Weights wanted (n,) from the signals and the state of the simulated drives (SIM)."""


def knows_truth(policy: Policy) -> bool:
    """Whether it is an upper bound to compare with, not a rule that a drive can run."""
    return policy.sensored or isinstance(policy, PrivilegedPolicy)


def require_runnable(policy: Policy) -> None:
    """Refuse what ``knows_truth``.

    Raises
    ------
    UserError
        Names the policy.
    """
    if knows_truth(policy):
        raise UserError(f"policy: {policy.name} knows the truth; give one that a drive can run")


def design_for(policy: Policy, design: DriveDesign) -> DriveDesign:
    """Design with the settings that the policy needs."""
    return dataclasses.replace(design, **policy.settings)


def decide(policy: Policy, obs: Signals, sims: Array) -> NDArray[np.float32]:
    """Weights wanted (n,); only a privileged policy sees the simulated drives."""
    # a protocol's isinstance takes 100 times as long
    knowing = getattr(policy, "act_knowing", None)
    chosen: NDArray[np.float32] = policy.act(obs) if knowing is None else knowing(obs, sims)
    return chosen


@runtime_checkable
class GainPolicy(Policy, Protocol):
    """A policy that sets gains of the drive besides k_s."""

    ranges: Mapping[str, Gain]
    """Range of each gain that it sets; empty: k_s alone."""

    def act_gains(self, obs: Signals) -> Values:
        """Values of the gains (n, GAIN_N), -1 to 1, at the signals that ``act`` just saw."""


NO_GAINS: Mapping[str, Gain] = {}


def gains_of(policy: Policy) -> Mapping[str, Gain]:
    """Gains that a policy sets besides k_s, by name."""
    found: Mapping[str, Gain] = getattr(policy, "ranges", NO_GAINS)
    return found


def decide_gains(policy: Policy, obs: Signals, gains: Array) -> None:
    """Write the values that a policy with ``gains_of`` wants into records of ``GAINS`` (n,).

    Raises
    ------
    UserError
        As ``act_gains``.
    """
    write_wanted(gains, act_gains(policy, obs))


def act_gains(policy: Policy, obs: Signals) -> Values:
    """Values (n, GAIN_N) that a policy with ``gains_of`` wants, -1 to 1.

    Raises
    ------
    UserError
        They have another shape, or one is not from -1 to 1.
    """
    found = policy.act_gains(obs)  # type: ignore[attr-defined] # as for ``decide``
    return checked(found, (len(obs), GAIN_N), -1.0, f"policy {policy.name}: act_gains")


def checked(x: ArrayLike, shape: tuple[int, ...], low: float, where: str) -> NDArray[np.float32]:
    """What a policy answered, clipped where it is no more than ``ROUNDING`` beyond its range.

    Parameters
    ----------
    shape : what it has to be, the drives first
    low : least value; 1 is the largest
    where : begin of an error's text

    Raises
    ------
    UserError
        It has another shape, or one number is not from ``low`` to 1; the core would keep the last
        weight, or take the static gain in its place.
    """
    values = np.asarray(x, dtype=np.float32)
    if values.shape != shape:
        raise UserError(f"{where} gave shape {values.shape} for {shape[0]} drives; give {shape}")
    least, most = low - ROUNDING, 1.0 + ROUNDING
    if not (values.min(initial=1.0) >= least and values.max(initial=low) <= most):
        inside = (values >= least) & (values <= most)
        raise UserError(f"{where} gave {values[~inside][0]:g}; give {low:g} to 1")
    return values.clip(low, 1.0)


class TablePolicy:
    """A schedule table, looked up by the code that runs on the target. It has no memory.

    Parameters
    ----------
    name : str
    table : KsTable
    settings : mapping, optional
        See ``Policy``.
    """

    sensored = False

    def __init__(self, name: str, table: KsTable, settings: Settings = NO_SETTINGS) -> None:
        self.name = name
        self.table = table
        self.settings = settings

    def reset(self, n: int) -> None:
        """Nothing to forget."""

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Interpolated weights (n,)."""
        return self.table.evaluate(obs)

    @property
    def ranges(self) -> Mapping[str, Gain]:
        """Range of each gain that the table sets."""
        return self.table.ranges

    def act_gains(self, obs: Signals) -> Values:
        """Interpolated values of the gains (n, GAIN_N)."""
        return self.table.evaluate_gains(obs)
