"""Importers that turn a user's copy of a benchmark, or maps of ROS, into scenarios."""

from .barn import read_barn
from .maps import read_maps

__all__ = ["read_barn", "read_maps"]
