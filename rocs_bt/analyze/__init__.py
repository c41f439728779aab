"""Analyze block of MAPE-K: analysers detect changes of the world, update Knowledge and notify Plan (paper, 4.2).

Only `agent` and the packages above it import this package.
"""

from collections.abc import Mapping

from .analyze import Analyze
from .local_map import LocalMap
from .localise import Localise
from .pass_changes import PassMessages, PassOrientation, PassPosition, PassRange
from .peer_analyze import PeerAnalyze
from .track_objects import TrackObjects

__all__ = [
    "ANALYZERS",
    "Analyze",
    "Localise",
    "PassMessages",
    "PassOrientation",
    "PassPosition",
    "PassRange",
    "PeerAnalyze",
]

_SHIPPED = (LocalMap, Localise, PassMessages, PassOrientation, PassPosition, PassRange, PeerAnalyze, TrackObjects)

ANALYZERS: Mapping[str, type[Analyze]] = {a.__name__: a for a in _SHIPPED}
"""Analysers available in robot.toml, keyed by class name."""
