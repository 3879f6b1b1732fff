"""Processor in the loop: runs the exported code on an emulated Cortex-M4F."""
