"""Is a drive built in right? The core's check, on a simulated drive or on a log."""
