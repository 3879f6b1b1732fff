"""All figures. Needs the extra ``plot``."""
