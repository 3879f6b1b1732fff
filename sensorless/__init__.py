"""Learned hand-over between two position estimators of a sensorless drive."""
