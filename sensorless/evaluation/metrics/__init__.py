"""Metrics: what is measured in a run, one function per metric."""
