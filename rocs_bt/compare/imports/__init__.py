"""Importers that turn a user's copy of other benchmarks into scenarios."""

from .barn import read_barn
from .movingai import read_movingai
from .mrpb import read_mrpb

__all__ = ["read_barn", "read_movingai", "read_mrpb"]
