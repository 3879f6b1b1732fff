"""Numbers that the scripts of studies take: a wrong one is told in one line."""

from argparse import ArgumentTypeError

from sensorless.envs.counter_random import check_seed
from sensorless.errors import UserError


def _whole(text: str) -> int:
    try:
        return int(text)
    except ValueError:
        raise ArgumentTypeError(f"{text!r}; give a whole number") from None


def a_seed(text: str) -> int:
    """A seed, 0 to 2^63 - 1."""
    value = _whole(text)
    try:
        check_seed(value)
    except UserError as error:
        raise ArgumentTypeError(str(error)) from None
    return value


def a_count(text: str) -> int:
    """A number of things, 1 or more."""
    value = _whole(text)
    if value < 1:
        raise ArgumentTypeError(f"{value}; give 1 or more")
    return value
