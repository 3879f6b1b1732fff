"""The policy as an interpolation table, and its training with PPO."""
