"""The control core in C99, its simulation, and the binding that makes both a Python module."""
