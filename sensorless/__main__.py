"""``python -m sensorless``."""

from sensorless.cli.main import main

main()
