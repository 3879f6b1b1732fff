"""CMA-ES on the numbers of a rule."""
