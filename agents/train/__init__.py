"""Training by PPO."""
