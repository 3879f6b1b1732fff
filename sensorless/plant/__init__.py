"""The machine alone under given voltages."""
