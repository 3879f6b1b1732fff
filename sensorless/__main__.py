"""``python -m sensorless``."""

from sensorless.cli import main

main()
