"""Is a drive integrated correctly? The core's check, on a simulated drive or on a log."""
