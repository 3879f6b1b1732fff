"""One HTML page about a schedule."""
