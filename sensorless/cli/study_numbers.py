"""Numbers that the scripts of studies take: a wrong one is told in one line."""

import argparse

from sensorless.envs.counter_random import LARGEST


def _whole(text: str, least: int, most: int) -> int:
    try:
        value = int(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r}: give a whole number") from None
    if not least <= value <= most:
        known = "2^63 - 1" if most == LARGEST else most
        raise argparse.ArgumentTypeError(f"{text}: give {least} to {known}")
    return value


def a_seed(text: str) -> int:
    """A seed, 0 to 2^63 - 1."""
    return _whole(text, 0, LARGEST)


def a_count(text: str) -> int:
    """A number of things, 1 or more."""
    return _whole(text, 1, LARGEST)
