"""Runs the machine alone under given voltages."""
