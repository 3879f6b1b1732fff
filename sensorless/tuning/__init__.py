"""Tuning of a rule's parameters by CMA-ES."""
