"""Metrics: what is measured in a run, one function per metric."""

RIPPLE_WINDOW = 0.02
"""Length of the moving mean of torque ripple, and width of a peak-to-peak window [s]."""
