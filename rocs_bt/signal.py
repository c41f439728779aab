"""Signals: numbers that change every period and are declared before they are written (docs/architecture.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .units import NONE, Dimension


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
