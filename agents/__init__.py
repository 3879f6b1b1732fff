"""Policies that learn, an interpolation table or a small network, and their training with PPO."""
