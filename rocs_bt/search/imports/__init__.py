"""Importers that turn a user's copy of a benchmark, or maps of ROS, into scenarios."""
