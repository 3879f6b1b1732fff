"""A drive that is stepped without a machine, which its lock detector would report."""

from sensorless.core.api import Array


def unwatched(params: Array) -> None:
    """Set the thresholds of lost lock so high that nothing reaches them."""
    for name in ("e_floor", "jump", "i_off"):
        params["lock"][name] = 1e30
