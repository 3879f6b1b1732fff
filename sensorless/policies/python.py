"""A policy that a user wrote in Python, by the word MODULE:NAME.

NAME is a class or a function of the machine (a ``Motor``) that gives the policy. All that a policy
must have is ``act``; the rest of ``sensorless.policy.Policy`` has defaults. It is judged like any
other: it sees what firmware can know, and what it answers is checked at every decision.
"""

import dataclasses
import importlib
import os
import re
import sys
import sysconfig
import traceback
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sensorless.core.gains import GAIN_N, GAIN_NAMES, RANGE, Gain, Values
from sensorless.design.drive import DriveDesign
from sensorless.envs.signals import bounded
from sensorless.errors import UserError, has_control, shown
from sensorless.machine.motor import Motor
from sensorless.policy import NO_SETTINGS, Settings, Signals, checked, gains_of
from sensorless.settings import settings_of

WORD = re.compile(r"[^\W\d]\w*(\.[^\W\d]\w*)*:[^\W\d]\w*")


class PythonPolicy:
    """A user's policy with the defaults filled in and every answer checked.

    It gets a copy of the signals within their bounds, as an environment gives them: drives that are
    lost run on beyond, and a policy may write into what it gets.

    Parameters
    ----------
    spec : str
        Word that names it in errors.
    own : object
        What the user's class or function gave.

    Raises
    ------
    UserError
        ``act`` is missing, or another part is of the wrong kind.
    """

    sensored = False

    def __init__(self, spec: str, own: Any) -> None:
        self._spec, self._own = spec, own
        with self._told("its attributes"):
            for part in ("act", "name", "settings", "ranges", "act_gains", "sensored"):
                getattr(own, part, None)  # a property may fail
        if isinstance(own, type) or not callable(getattr(own, "act", None)):
            raise self._error(f"gave {_kind(own)}, not a policy; give it act(obs)")
        if getattr(own, "sensored", False) or hasattr(own, "act_knowing"):
            raise self._error("asks for the truth; a policy sees what firmware can know")
        self.name = getattr(own, "name", spec.partition(":")[2])
        self.settings: Settings = getattr(own, "settings", NO_SETTINGS)
        self.ranges: Mapping[str, Gain] = gains_of(own)
        if not isinstance(self.name, str) or not self.name or has_control(self.name):
            raise self._error(f"name: {shown(self.name)}; give text of one line")
        if not isinstance(self.settings, Mapping):
            raise self._error(f"settings: {_kind(self.settings)}; give settings by name")
        for setting in self.settings:
            if setting not in settings_of(DriveDesign):
                raise self._error(
                    f"settings: {shown(setting)} is unknown; sensorless settings lists all"
                )
        with self._told("settings"):
            dataclasses.replace(DriveDesign(), **self.settings)
        sets = callable(getattr(own, "act_gains", None))
        if not isinstance(self.ranges, Mapping):
            raise self._error(f"ranges: {shown(self.ranges)}; give a Gain by name")
        if (sets and not hasattr(own, "ranges")) or (self.ranges and not sets):
            has, lacks = ("act_gains", "ranges") if sets else ("ranges", "act_gains(obs)")
            raise self._error(f"has {has} without {lacks}; give both, or neither for k_s alone")
        for gain, x in self.ranges.items():
            if gain not in GAIN_NAMES:
                known = ", ".join(GAIN_NAMES)
                raise self._error(f"ranges: {shown(gain)} is unknown; choose from {known}")
            if not isinstance(x, Gain) or not x.usable:
                raise self._error(f"ranges: {gain}: {shown(x)}; give {RANGE}")

    def reset(self, n: int) -> None:
        """Forget the past before n drives start, if it has any."""
        with self._told("reset"):
            getattr(self._own, "reset", lambda n: None)(n)

    def act(self, obs: Signals) -> NDArray[np.float32]:
        """Weights (n,)."""
        with self._told("act"):
            k_s = np.asarray(self._own.act(bounded(obs)), dtype=np.float32)
        return checked(k_s, (len(obs),), 0.0, f"policy: {self._spec!r} act")

    def act_gains(self, obs: Signals) -> Values:
        """Values of the gains (n, GAIN_N)."""
        with self._told("act_gains"):
            values = np.asarray(self._own.act_gains(bounded(obs)), dtype=np.float32)
        return checked(values, (len(obs), GAIN_N), -1.0, f"policy: {self._spec!r} act_gains")

    @contextmanager
    def _told(self, where: str) -> Iterator[None]:
        with told(self._spec, where):
            yield

    def _error(self, text: str) -> UserError:
        return UserError(f"policy: {self._spec!r} {text}")


def is_python(spec: str) -> bool:
    """Whether a word has the form MODULE:NAME."""
    return WORD.fullmatch(spec) is not None


def python_policy(spec: str, motor: Motor) -> PythonPolicy:
    """Policy by MODULE:NAME; modules of the working directory count.

    Raises
    ------
    UserError
        There is no such module or name, it fails, or what it gives is no policy.
    """
    module, _, name = spec.partition(":")
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())
    with told(spec, "import"):
        try:
            found = importlib.import_module(module)
        except ModuleNotFoundError as error:
            if not f"{module}.".startswith(f"{error.name}."):
                raise
            raise UserError(
                f"policy: {spec!r}: no module {error.name!r} in this folder or on PYTHONPATH, and "
                f"no rule {module!r}; 'sensorless evaluate --list' names the rules"
            ) from None
    if not hasattr(found, name):
        public = ", ".join(sorted(key for key, x in vars(found).items() if _is_own(x, module)))
        has = f"it has {public}" if public else "it has no class or function of its own"
        raise UserError(f"policy: {spec!r}: {module} has no {name!r}; {has}")
    make = getattr(found, name)
    if not callable(make):
        raise UserError(
            f"policy: {spec!r} is {_kind(make)}; name a class or a function of the motor"
        )
    with told(spec, f"{name}(motor)"):
        own = make(motor)
    return PythonPolicy(spec, own)


@contextmanager
def told(spec: str, where: str) -> Iterator[None]:
    """Make an error of a user's code one that names file and line.

    Raises
    ------
    UserError
        In the place of whatever the code raised.
    """
    try:
        yield
    except UserError:
        raise
    except (Exception, SystemExit) as error:  # a script that ends itself would end the command
        frames = traceback.extract_tb(error.__traceback__)
        not_theirs = (__file__, "<", *map(sysconfig.get_path, ("stdlib", "purelib")))
        theirs = [f for f in frames if not f.filename.startswith(not_theirs)]
        at = f" ({theirs[-1].filename}:{theirs[-1].lineno})" if theirs else ""
        text = next(iter(str(error).strip().splitlines()), "")
        raise UserError(
            f"policy: {spec!r} fails in {where}: {type(error).__name__}: {text}{at}"
        ) from error


def _is_own(x: object, module: str) -> bool:
    return callable(x) and getattr(x, "__module__", None) == module


def _kind(x: object) -> str:
    return "None" if x is None else f"an object of type {type(x).__name__}"
