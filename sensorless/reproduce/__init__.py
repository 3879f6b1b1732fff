"""The source paper's figures and numbers."""
