"""Search for trouble: where does a planner fail, and what is the least that makes it fail."""

from .draft import Draft
from .keep import again, keep, refuse_taken
from .playing import SEED, Player
from .search import FAILURES, SearchOptions, Trouble, default_name, search
from .shrink import Fairness, Shrinking
from .space import Drawn, Space

__all__ = [
    "FAILURES",
    "SEED",
    "Draft",
    "Drawn",
    "Fairness",
    "Player",
    "SearchOptions",
    "Shrinking",
    "Space",
    "Trouble",
    "again",
    "default_name",
    "keep",
    "refuse_taken",
    "search",
]
