"""Search for failures: find a scene in which a planner fails, and simplify the scene as far as possible."""

from .draft import Draft
from .keep import keep, play_command, refuse_existing
from .player import SEED, Player
from .run_search import FAILURES, SearchOptions, SearchResult, default_name, search
from .shrink import Fairness, Shrinking
from .space import SampledScene, SearchSpace

__all__ = [
    "FAILURES",
    "SEED",
    "Draft",
    "Fairness",
    "Player",
    "SampledScene",
    "SearchOptions",
    "SearchResult",
    "SearchSpace",
    "Shrinking",
    "default_name",
    "keep",
    "play_command",
    "refuse_existing",
    "search",
]
