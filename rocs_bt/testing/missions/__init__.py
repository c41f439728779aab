"""Tests of missions without a robot: scripted leaves, substitution, fault injection, a simulated clock, coverage."""

from .coverage import TreeCoverage
from .inject import Breaks, Flaky, Raises, inject
from .play import PlayOptions, Trace, play
from .scripted import Scripted, ScriptedOutcomes
from .substitute import Rule, read_rules, substitute

__all__ = [
    "Breaks",
    "Flaky",
    "PlayOptions",
    "Raises",
    "Rule",
    "Scripted",
    "ScriptedOutcomes",
    "Trace",
    "TreeCoverage",
    "inject",
    "play",
    "read_rules",
    "substitute",
]
