"""Reruns the experiments of the source paper: its printed numbers, and those of our drive."""
