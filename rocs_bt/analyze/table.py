"""The analysers that robot.toml may name."""

from __future__ import annotations

from collections.abc import Mapping

from .analyze import Analyze
from .pass_orientation import PassOrientation
from .pass_position import PassPosition
from .pass_range import PassRange

ANALYZERS: Mapping[str, type[Analyze]] = {a.__name__: a for a in (PassOrientation, PassPosition, PassRange)}
