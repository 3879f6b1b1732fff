"""Policies by name: rules, tuned rules, learned schedules."""
