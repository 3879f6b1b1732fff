"""``python -m sensorless``."""

from sensorless.cli.app import main

main()
