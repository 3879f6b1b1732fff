"""HTML pages: a report about a schedule, a check of a motor."""
