"""Scenes from other people's benchmarks: a user's own copy of them becomes ordinary scenarios."""

from .barn import read_barn
from .movingai import read_movingai
from .mrpb import read_mrpb

__all__ = ["read_barn", "read_movingai", "read_mrpb"]
