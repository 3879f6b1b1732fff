"""The policy that is a table."""
