"""What a drive is put through: scenarios, suites, random machines."""
