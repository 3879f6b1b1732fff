"""Whether a machine suits this drive: findings without running it, and the verdict."""
