"""Sensors that read topics and actuators that publish commands."""
