"""From a word on the command line to a policy."""

import math
from collections.abc import Callable
from pathlib import Path

from sensorless.agents.loading import load_run
from sensorless.baselines.constant import constant_table
from sensorless.baselines.hysteresis import GAP, Hysteresis
from sensorless.baselines.linear import EQ25_BAND, linear_table
from sensorless.baselines.sensored import Sensored
from sensorless.envs.policy import Policy, TablePolicy
from sensorless.errors import UserError
from sensorless.motor import Motor

RUN = "RUN"


def known() -> dict[str, str]:
    """Every policy that ``make_policy`` understands, and what it is."""
    return {
        "eq25": "linear ramp of the paper, 20 to 26.7 % of rated speed (300 to 400 r/min there)",
        "linear:LO,HI": "linear ramp from LO to HI [r/min]",
        "hysteresis": "hard switch at the centre of the paper's band, gap of +-5 %",
        "hysteresis:LO,HI": "hard switch up at HI, down at LO [r/min]",
        "constant:K": "K at all times, 0 to 1",
        "hfi": "injection alone: constant:1",
        "smo": "sliding-mode observer alone: constant:0",
        "sensored": "the true angle, no estimator",
        RUN: "folder of a training run, by its path",
    }


def make_policy(spec: str, motor: Motor) -> Policy:
    """Policy of a word as in ``known``, for one motor.

    A word of the list goes before a folder of the same name; write ``./NAME`` for the folder.

    Raises
    ------
    UserError
        Unknown name, or a number out of its range.
    """
    word, colon, text = spec.partition(":")
    build = _BUILDERS.get(word)
    if build is not None:
        return build(spec, text if colon else None, motor)
    if Path(spec).is_dir():
        return load_run(Path(spec), motor)
    raise UserError(f"policy: {spec!r}: no such rule or folder; allowed: {', '.join(known())}")


def _eq25(spec: str, text: str | None, motor: Motor) -> Policy:
    _no_numbers(spec, text)
    return TablePolicy(spec, linear_table(*EQ25_BAND))


def _linear(spec: str, text: str | None, motor: Motor) -> Policy:
    low, high = _band(spec, text, motor)
    return TablePolicy(spec, linear_table(low, high))


def _hysteresis(spec: str, text: str | None, motor: Motor) -> Policy:
    centre = 0.5 * (EQ25_BAND[0] + EQ25_BAND[1])
    low, high = (1.0 - GAP) * centre, (1.0 + GAP) * centre
    if text is not None:
        low, high = _band(spec, text, motor)
    return Hysteresis(spec, low, high)


def _constant(spec: str, text: str | None, motor: Motor) -> Policy:
    numbers = _numbers(text)
    if len(numbers) != 1 or not 0.0 <= numbers[0] <= 1.0:
        raise UserError(f"policy: {spec!r}; allowed: constant:K with K from 0 to 1")
    return TablePolicy(spec, constant_table(numbers[0]))


def _hfi(spec: str, text: str | None, motor: Motor) -> Policy:
    _no_numbers(spec, text)
    return TablePolicy(spec, constant_table(1.0))


def _smo(spec: str, text: str | None, motor: Motor) -> Policy:
    _no_numbers(spec, text)
    return TablePolicy(spec, constant_table(0.0))


def _sensored(spec: str, text: str | None, motor: Motor) -> Policy:
    _no_numbers(spec, text)
    return Sensored()


_BUILDERS: dict[str, Callable[[str, str | None, Motor], Policy]] = {
    "eq25": _eq25,
    "linear": _linear,
    "hysteresis": _hysteresis,
    "constant": _constant,
    "hfi": _hfi,
    "smo": _smo,
    "sensored": _sensored,
}


def _no_numbers(spec: str, text: str | None) -> None:
    if text is not None:
        raise UserError(f"policy: {spec!r}; allowed: {spec.partition(':')[0]} without numbers")


def _numbers(text: str | None) -> list[float]:
    """Comma-separated numbers; nothing if one of them is none or not finite."""
    try:
        numbers = [float(part) for part in (text or "").split(",")]
    except ValueError:
        return []
    return numbers if all(map(math.isfinite, numbers)) else []


def _band(spec: str, text: str | None, motor: Motor) -> tuple[float, float]:
    """Two speeds in r/min as shares of rated speed."""
    numbers = _numbers(text)
    if len(numbers) != 2 or not 0.0 <= numbers[0] < numbers[1]:
        word = spec.partition(":")[0]
        raise UserError(f"policy: {spec!r}; allowed: {word}:LO,HI with 0 <= LO < HI [r/min]")
    return numbers[0] / motor.n_rated_rpm, numbers[1] / motor.n_rated_rpm
