"""Runs policies over suites and measures them."""
