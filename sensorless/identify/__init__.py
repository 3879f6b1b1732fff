"""Commissioning: curves that a real drive would measure."""
