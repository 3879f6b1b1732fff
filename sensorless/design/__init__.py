"""From physical settings to the numbers the drive runs on."""
