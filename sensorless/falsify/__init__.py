"""Searches for scenarios that a policy loses."""
