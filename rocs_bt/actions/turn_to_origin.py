"""TurnToOrigin = TurnAngle (paper, Table 2)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..action import Action, Body, MacroAction
from ..units import PositiveRadiansPerSecond
from .turn_to_position import TurnToPosition


@dataclass(kw_only=True, eq=False)
class TurnToOrigin(MacroAction):
    """Turn on the spot until the robot looks at the world frame's origin.

    Attributes:
        rate: Fastest turn [rad/s].
    """

    rate: PositiveRadiansPerSecond = 1.5

    def decompose(self, body: Body) -> Iterator[Action]:
        yield TurnToPosition(x=0.0, y=0.0, rate=self.rate)
