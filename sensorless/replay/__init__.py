"""Runs the drive's estimators over a recorded log."""
