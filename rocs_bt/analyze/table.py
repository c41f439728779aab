"""The analysers that robot.toml may name."""

from __future__ import annotations

from collections.abc import Mapping

from .analyze import Analyze
from .local_map import LocalMap
from .localise import Localise
from .pass_messages import PassMessages
from .pass_orientation import PassOrientation
from .pass_position import PassPosition
from .pass_range import PassRange
from .peer_analyze import PeerAnalyze
from .track_objects import TrackObjects

_SHIPPED = (LocalMap, Localise, PassMessages, PassOrientation, PassPosition, PassRange, PeerAnalyze, TrackObjects)

ANALYZERS: Mapping[str, type[Analyze]] = {a.__name__: a for a in _SHIPPED}
