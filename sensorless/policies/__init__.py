"""From a word to a policy."""
