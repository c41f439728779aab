"""Signals: numbers that change every period, declared before they are written (docs/architecture.md)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .units import NONE, Dimension


@dataclass(frozen=True)
class Signal:
    """The declaration of one signal; its values live in Knowledge's signal table.

    Attributes:
        name: What rules, leaves and analysers call it, such as `front` or `pose`.
        size: How many float64 values it has.
        dimensions: The dimension of each value, or one for all of them.
        bounds: Lowest and highest valid value, in SI units; a value outside of them is a broken one.
        max_age: How long a written value stays valid [s]; +inf for one that never gets stale.
        doc: One sentence for people.
    """

    name: str
    size: int = 1
    dimensions: tuple[Dimension, ...] = (NONE,)
    bounds: tuple[float, float] = (-math.inf, math.inf)
    max_age: float = math.inf
    doc: str = ""

    @property
    def dimension(self) -> Dimension | None:
        """The dimension all values share; None where they differ, as in a pose."""
        return self.dimensions[0] if len(set(self.dimensions)) == 1 else None
