"""The control core in C99 and the recipe that compiles it for Python."""
