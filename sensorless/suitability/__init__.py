"""Is a machine suitable: what is found without running it, and the verdict."""
