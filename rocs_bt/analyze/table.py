"""The analysers that robot.toml may name."""

from __future__ import annotations

from collections.abc import Mapping

from .analyze import Analyze
from .localise import Localise
from .pass_orientation import PassOrientation
from .pass_position import PassPosition
from .pass_range import PassRange
from .peer_analyze import PeerAnalyze

_SHIPPED = (Localise, PassOrientation, PassPosition, PassRange, PeerAnalyze)

ANALYZERS: Mapping[str, type[Analyze]] = {a.__name__: a for a in _SHIPPED}
