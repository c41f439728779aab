"""The type of an expression: a number or a truth value, single or a group of them, with its dimension."""

from __future__ import annotations

from dataclasses import dataclass

from ..units import NONE, Dimension


@dataclass(frozen=True)
class Kind:
    """What an expression gives.

    Attributes:
        dimension: The dimension its numbers share; None for truth values, and where they differ (as in a pose).
        size: How many values; 0 for a single one.
        boolean: True for truth values.
    """

    dimension: Dimension | None = NONE
    size: int = 0
    boolean: bool = False

    @property
    def mixed(self) -> bool:
        """Whether its numbers have different dimensions, so that nothing but an index can use them."""
        return self.dimension is None and not self.boolean

    @property
    def words(self) -> str:
        """For messages, such as `in m`, `6 values in m`, `true or false`."""
        if self.mixed:
            return f"{self.size} values of different units"
        one = "true or false" if self.boolean else f"in {self.dimension}"
        return f"{self.size} values {one}" if self.size else one


TRUTH = Kind(dimension=None, boolean=True)
PLAIN = Kind()
