"""Observers and blend over a recorded log."""
