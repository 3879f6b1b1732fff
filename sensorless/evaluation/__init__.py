"""Runs policies over suites of scenarios and measures how the drives did."""
