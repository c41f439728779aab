"""Question: an expression that a mission asks of the robot's signals."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ..expression import Expression, reading


@dataclass(frozen=True, eq=False)
class Question:
    """Asks one expression, of one snapshot a tick.

    Attributes:
        expression: The expression, true or false.
        snapshot: Gives the snapshot of the tick under way, and its time [s].
    """

    expression: Expression
    snapshot: Callable[[], tuple[Sequence[float], float]]

    def holds(self) -> bool:
        """Whether it holds now; false where it cannot be told."""
        return bool(self.expression(*self.snapshot()))

    def reading(self) -> str:
        """What it reads now, such as `min(front) = 0.21 m`."""
        return reading(self.expression.node, self.snapshot()[0])
