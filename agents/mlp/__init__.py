"""The policy that is a small network."""
