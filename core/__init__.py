"""The control core in C99, its simulation, and the Python binding of both."""
