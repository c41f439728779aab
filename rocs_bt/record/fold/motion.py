"""Motion of a robot in words, from its signals, and its tilt."""

from __future__ import annotations

import math
from collections.abc import Mapping

_SLOW = 0.02  # speed above which the robot counts as moving [m/s]
_TURNING = 0.1  # turn rate above which the robot counts as turning [rad/s]
_WORDS = {  # motion of each axis in words, by its signal: for positive and negative values
    "speed": ("moved ahead", "moved back"),
    "lateral_speed": ("moved left", "moved right"),
    "climb": ("climbed", "descended"),
}
_TILTED = math.radians(35.0)  # tilt above which a robot counts as tilted
_FALLEN = math.radians(60.0)  # tilt above which a robot is down (docs/architecture.md, outcomes)

MOTION = frozenset((*_WORDS, "turn_rate"))
"""Signals from which the motion of a robot is known."""


def motion_words(values: Mapping[str, float]) -> str:
    """Motion of a robot in words: along its fastest axis, and its turn."""
    along = {name: values[name] for name in _WORDS if math.isfinite(values.get(name, math.nan))}
    turn = values.get("turn_rate", math.nan)
    side = " left" if turn > 0.0 else " right"
    fastest = max(along, key=lambda name: abs(along[name]), default="")
    if fastest and abs(along[fastest]) > _SLOW:
        return _WORDS[fastest][along[fastest] < 0.0] + (f" turning{side}" if abs(turn) > _TURNING else "")
    if abs(turn) > _TURNING:
        return f"turned{side}"
    return "was stationary" if "speed" in along else "acted"


def tilt_words(tilt: float) -> str:
    """Words about a robot with a tilt [rad] that is not upright; empty for one that is, and for NaN."""
    if not tilt > _TILTED:
        return ""
    state = "had fallen" if tilt > _FALLEN else "was tilted"
    return f"{state}, with a tilt of {math.degrees(tilt):.0f} deg"
