"""A drive that is stepped without a machine, which its lock detector would report."""

from sensorless.core.api import Array


def unwatched(params: Array) -> None:
    """Set the thresholds of lost lock so high that nothing reaches them."""
    params["lock"]["alpha"], params["lock"]["jump"] = 0.0, 1e30
