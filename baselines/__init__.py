"""Hand-over rules that a learned schedule has to beat."""
