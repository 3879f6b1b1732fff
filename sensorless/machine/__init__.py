"""One motor: its file, its magnetics."""
