"""Processor in the loop: the export on an emulated Cortex-M4F."""
