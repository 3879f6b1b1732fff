"""A motor: its file and its magnetics."""
