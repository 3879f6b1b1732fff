"""What a user hands to the environments, and the checks on it."""

import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, SupportsIndex

import numpy as np
from numpy.typing import ArrayLike, NDArray

from sensorless.core.gains import DEFAULT, GAIN_NAMES, RANGE, Gain
from sensorless.decision import RUNNING, TRAINING
from sensorless.design.drive import DriveDesign
from sensorless.envs.counter_random import Seeds
from sensorless.envs.reward import RewardWeights
from sensorless.envs.scenarios.checked import checked_scenarios
from sensorless.envs.scenarios.scenario import Scenarios
from sensorless.envs.scenarios.stress import stress_1_scenarios
from sensorless.envs.scenarios.suites import sampler
from sensorless.envs.window_reward import WindowWeights
from sensorless.errors import UserError, shown
from sensorless.machine.motor import Motor
from sensorless.settings import check, number, read

Sampler = Callable[[Motor, Seeds], Scenarios]
KINDS: dict[str, tuple[Any, str]] = {
    "motor": (Motor | str | Path, "the name of a shipped machine, a TOML file, or a Motor"),
    "design": (DriveDesign, "a DriveDesign, such as DriveDesign(estimator='flux')"),
    "scenarios": (Callable | str, "a suite by name, or a function of (motor, seeds)"),
    "weights": (RewardWeights | WindowWeights, "RewardWeights or WindowWeights"),
}
"""Types of fields that are no numbers, and those types in words."""
ROUNDING = np.float32(1.000001)
"""Largest magnitude of an action: rounding may carry one past 1, where it is clipped."""

MOST_ENVS = 1_000_000
"""Most drives of a vector environment: 5 GB."""
MOST_SEED = 2**64 - 1
"""Largest seed of a drive."""


@dataclass(frozen=True)
class BlendSettings:
    """What an environment simulates and rewards; the keywords of both environments."""

    motor: Motor | str | Path = "paper"
    """Machine: the name of a shipped one, a TOML file, or a `Motor`."""
    design: DriveDesign = field(default_factory=DriveDesign)
    """Settings of the drive: estimator, bandwidths, control; also those by name, as a file has
    them."""
    scenarios: Sampler | str = stress_1_scenarios
    """A suite by name, such as ``handoff``, or a function of (motor, seeds (n,)) that draws n
    scenarios, row i from seed i alone."""
    weights: RewardWeights | WindowWeights = field(default_factory=RewardWeights)
    """Weights of the reward's terms; their type says which reward it is."""
    decision_period: float = number(
        RUNNING, "s", 1e-6, 1, "time between decisions, rounded to whole PWM periods"
    )
    max_episode_steps: int | None = None
    """Decisions until truncation; None: run to the scenario's end."""

    @classmethod
    def by_name(cls, settings: Mapping[str, Any]) -> "BlendSettings":
        """Settings from the keywords of an environment.

        Raises
        ------
        UserError
            A name is unknown, or as for the fields.
        """
        for name, value in settings.items():
            if name in DriveDesign.__dataclass_fields__:
                raise UserError(
                    f"{name}: {shown(value)}: is a setting of the drive; give "
                    f"design=DriveDesign({name}={shown(value)}) of sensorless.design.drive"
                )
            if name not in cls.__dataclass_fields__:
                known = ", ".join(cls.__dataclass_fields__)
                raise UserError(f"{name}: {shown(value)}: is unknown; choose from {known}")
        given = dict(settings)
        if isinstance(design := given.get("design"), Mapping):
            given["design"] = DriveDesign(**read(DriveDesign, design, "design: "))
        return cls(**given)

    @property
    def ranges(self) -> dict[str, Gain]:
        """Range of each gain that the agent sets besides k_s, in the order of the action: none."""
        return {}

    @property
    def sampler(self) -> Sampler:
        """Function that draws the scenarios."""
        return sampler(self.scenarios) if isinstance(self.scenarios, str) else self.scenarios

    def __post_init__(self) -> None:
        """Check every field.

        Raises
        ------
        UserError
            Names the field, its value and what it must be.
        """
        check(self)
        for name, (kinds, words) in KINDS.items():
            value = getattr(self, name)
            if not isinstance(value, kinds):
                raise UserError(f"{name}: {shown(value)}; give {words}")
        _ = self.sampler  # a suite exists
        steps = self.max_episode_steps
        if steps is not None and (_index(steps) or 0) < 1:
            raise UserError(f"max_episode_steps: {steps!r}: must be None or a whole number above 0")


@dataclass(frozen=True)
class GainSettings(BlendSettings):
    """The same with the defaults of ``sensorless/Blend-v1``, whose agent also sets gains."""

    weights: RewardWeights | WindowWeights = field(default_factory=WindowWeights)
    decision_period: float = number(
        TRAINING, "s", 1e-6, 1, "time between decisions, rounded to whole PWM periods"
    )
    gains: tuple[str, ...] = tuple(DEFAULT)
    """Gains that the agent sets besides k_s, by name, in the order of the action."""
    gain_ranges: Mapping[str, Gain] = field(default_factory=dict)
    """Ranges other than those of ``gains.DEFAULT``, a `core.gains.Gain` by name."""

    @property
    def ranges(self) -> dict[str, Gain]:
        """Range of each gain that the agent sets, in the order of the action."""
        return {name: self.gain_ranges.get(name, DEFAULT[name]) for name in self.gains}

    def __post_init__(self) -> None:
        """Check every field; errors as in ``BlendSettings``."""
        super().__post_init__()
        if not isinstance(self.gains, Sequence):
            raise UserError(f"gains: {shown(self.gains)}; give a tuple of names, () for none")
        if not isinstance(self.gain_ranges, Mapping):
            raise UserError(f"gain_ranges: {shown(self.gain_ranges)}; give a Gain by name, or {{}}")
        names = (self.gains,) if isinstance(self.gains, str) else tuple(self.gains)
        for name in (*names, *self.gain_ranges):
            if name not in GAIN_NAMES:
                known = ", ".join(DEFAULT)
                raise UserError(f"gains: {shown(name)} is unknown; choose from {known}")
        if len(set(names)) < len(names):
            raise UserError(f"gains: {', '.join(names)}; name each gain once")
        for name, x in self.gain_ranges.items():
            if name not in names:
                raise UserError(f"gain_ranges: {name!r} is not in gains = {names}; add it there")
            if not isinstance(x, Gain) or not x.usable:
                raise UserError(f"gain_ranges: {name}: {shown(x)}; give {RANGE}")
        object.__setattr__(self, "gains", names)


def checked_render_mode(mode: object, known: Sequence[str]) -> str | None:
    """Return the render mode.

    Raises
    ------
    UserError
        It is unknown.
    """
    if mode is None or (isinstance(mode, str) and mode in known):
        return mode
    choices = ", ".join(["None", *(repr(name) for name in known)])
    several = "" if known else ": many environments at once draw nothing"
    raise UserError(f"render_mode: {mode!r}; choose from {choices}{several}")


def checked_count(n: object) -> int:
    """Return the number of drives.

    Raises
    ------
    UserError
        It is not a whole number from 1 to ``MOST_ENVS``.
    """
    count = _index(n)
    if count is None or not 1 <= count <= MOST_ENVS:
        raise UserError(f"num_envs: {n!r}; give a whole number from 1 to {MOST_ENVS}")
    return count


def checked_seeds(seed: object, n: int) -> list[int | None]:
    """Return the seeds of n drives: s, s + 1, ... from one seed s, or those of a list of n.

    Raises
    ------
    UserError
        A seed is not a whole number in range, or a list has another length than n.
    """
    if seed is None:
        return [None] * n
    first = _index(seed)
    if first is not None:
        if not 0 <= first <= MOST_SEED - (n - 1):
            most = f"2^64 - {n}, one seed for each of {n} drives" if n > 1 else "2^64 - 1"
            raise UserError(f"seed: {shown(seed)}; give a whole number from 0 to {most}")
        return list(range(first, first + n))
    if not isinstance(seed, Sequence | np.ndarray) or len(seed) != n:
        wanted = f"None, a whole number, or a list of {n}" if n > 1 else "None or a whole number"
        raise UserError(f"seed: {shown(seed)}; give {wanted}")
    return [None if s is None else _seed(s) for s in seed]


def checked_actions(actions: ArrayLike, n: int, m: int) -> NDArray[np.float32]:
    """Return the actions of n drives, (n, m) within -1 to 1.

    Parameters
    ----------
    actions : array, shape (n, m), or flat for one drive or k_s alone
    n, m : int
        Drives, and numbers in an action.

    Raises
    ------
    UserError
        The shape is another, or an action is not a number from -1 to 1; the message names the
        first one.
    """
    wanted = (n, m) if n > 1 else (m,)
    try:
        if np.iscomplexobj(actions):
            raise TypeError
        action = np.asarray(actions, dtype=np.float32)
    except (TypeError, ValueError, OverflowError):
        raise UserError(f"action: {shown(actions)}; give numbers of shape {wanted}") from None
    if action.shape != (n, m) and not (1 in (n, m) and action.shape == (n * m,)):
        raise UserError(f"action: shape {action.shape}; give shape {wanted}")
    action = action.reshape(n, m)
    good = np.abs(action) <= ROUNDING
    if np.count_nonzero(good) < n * m:
        bad = int(np.argmin(good.all(axis=1)))
        value = np.reshape(actions, (n, m))[bad]
        j = int(np.argmin(good[bad]))
        at, means = f"[{j}]" if m > 1 else "", ", which is k_s from 0 to 1" if j == 0 else ""
        raise UserError(f"action[{bad}]{at}: {value[j]}; give -1 to 1{means}")
    return np.clip(action, np.float32(-1.0), np.float32(1.0))


def checked_scenario(options: dict[str, Any] | None, n: int) -> Scenarios | None:
    """Return the n scenarios in the options of a reset, if there are any.

    Raises
    ------
    UserError
        No options by name, an unknown one, or a scenario that is not `Scenarios` of n rows, or as
        ``checked_scenarios``.
    """
    if not isinstance(options, Mapping | None):
        raise UserError(f"options: {shown(options)}; give None or {{'scenario': Scenarios}}")
    known = dict(options or {})
    scenario = known.pop("scenario", None)
    for name in known:
        raise UserError(f"options: {shown(name)} is unknown; the only option is 'scenario'")
    if scenario is None:
        return None
    where = "options['scenario']"
    if not isinstance(scenario, Scenarios):
        raise UserError(f"{where}: {shown(scenario)}; give Scenarios with {n} rows")
    return checked_scenarios(scenario, n, where)


def _index(value: object) -> int | None:
    """Return the whole number that a value is; None: it is none."""
    try:
        return operator.index(value) if isinstance(value, SupportsIndex) else None
    except TypeError:
        return None


def _seed(value: object) -> int:
    seed = _index(value)
    if seed is None or not 0 <= seed <= MOST_SEED:
        raise UserError(f"seed: {shown(value)}; give a whole number from 0 to 2^64 - 1")
    return seed
