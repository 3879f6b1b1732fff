"""Commissioning: curves that a real drive would measure in a test run."""
