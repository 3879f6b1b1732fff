"""The drive measures its machine: resistance, inverter, flux map, magnet and inertia."""
