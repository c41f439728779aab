"""Missions without a robot: scripted leaves, substitution, faults on purpose, a clock of one's own, coverage."""

from .coverage import TreeCoverage
from .inject import Breaks, Flaky, Raises, inject
from .letters import Letters, Scripted
from .play import PlayOptions, play
from .substitute import Rule, read_rules, substitute
from .trace import Trace

__all__ = [
    "Breaks",
    "Flaky",
    "Letters",
    "PlayOptions",
    "Raises",
    "Rule",
    "Scripted",
    "Trace",
    "TreeCoverage",
    "inject",
    "play",
    "read_rules",
    "substitute",
]
