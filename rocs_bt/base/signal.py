"""Signals: numbers that change every period and are declared before they are written (docs/architecture.md)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from .units import ANGLE, LENGTH, NONE, SPEED, Dimension


@dataclass(frozen=True)
class Signal:
    """Declaration of a signal; its values are in the signal table of Knowledge.

    Attributes:
        name: Name that rules, leaves and analysers use, such as `front` or `pose`.
        size: Number of values (float64).
        dimensions: Dimension of each value, or a single one for all values.
        bounds: Minimum and maximum of all values, SI units; a value outside is invalid.
        max_age: Time for which a written value stays valid [s]; +inf if it never becomes stale.
        doc: Description in one sentence.
    """

    name: str
    size: int = 1
    dimensions: tuple[Dimension, ...] = (NONE,)
    bounds: tuple[float, float] = (-math.inf, math.inf)
    max_age: float = math.inf
    doc: str = ""

    @property
    def dimension(self) -> Dimension | None:
        """Common dimension of all values; None if they differ, as in a pose."""
        return self.dimensions[0] if len(set(self.dimensions)) == 1 else None


_ANY_LENGTH, _ANY_SPEED, _RANGE = (-1e6, 1e6), (-1e3, 1e3), (0.0, math.inf)
_OPTIONAL = (
    Signal("course_speed", 1, (SPEED,), (0.0, 1e3), doc="Speed of the body in its direction of motion."),
    Signal("lateral_speed", 1, (SPEED,), _ANY_SPEED, doc="Sideways speed of the body, left positive."),
    Signal("climb", 1, (SPEED,), _ANY_SPEED, doc="Vertical speed of the body, up positive."),
    Signal("tilt", 1, (ANGLE,), (0.0, math.pi), doc="Angle between the body's z axis and the vertical."),
    Signal("height", 1, (LENGTH,), _ANY_LENGTH, doc="Height of the body above the plane z = 0 of the world."),
    Signal("course_range", 1, (LENGTH,), _RANGE, doc="Range in the direction of motion; +inf while stationary."),
    Signal("above", 1, (LENGTH,), _RANGE, doc="Ranges of the upward beams, each divided by its weight."),
    Signal(
        "below",
        1,
        (LENGTH,),
        _RANGE,
        doc="Ranges of the downward beams, each divided by its weight; the first one straight down.",
    ),
    Signal("battery", 1, bounds=(0.0, 1.0), doc="Charge of the battery, 1 for full."),
)
OPTIONAL_SIGNALS: Mapping[str, Signal] = MappingProxyType({signal.name: signal for signal in _OPTIONAL})
"""Standard signals that only some robots have, by name; a rule that reads one must list it in `require`.

`above` and `below` are groups, so their size depends on the robot. The declarations have no `max_age`.
"""
