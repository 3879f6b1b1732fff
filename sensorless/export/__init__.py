"""From a policy to a folder of C99."""
