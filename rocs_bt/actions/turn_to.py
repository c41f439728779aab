"""TurnTo: look in a direction of the world."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ..action import Action, Body, MacroAction
from ..geometry import wrap_angle
from ..units import PositiveRadians, PositiveRadiansPerSecond, Radians
from .pose import PoseWatch
from .stop import Stop
from .turn_angle import TurnAngle


@dataclass(kw_only=True, eq=False)
class TurnTo(MacroAction):
    """Turn on the spot, the short way round, to a yaw of the world frame; checked when the robot stands.

    Attributes:
        yaw: In the world frame [rad].
        rate: Fastest turn [rad/s].
        tolerance: When it is done [rad].
    """

    yaw: Radians
    rate: PositiveRadiansPerSecond = 1.5
    tolerance: PositiveRadians = 0.02

    def decompose(self, body: Body) -> Iterator[Action]:
        watch = PoseWatch()
        while True:
            pose = watch.look(body)
            if pose is not None:
                error = wrap_angle(self.yaw - pose.yaw)
                if abs(error) <= self.tolerance:
                    return
                yield TurnAngle(angle=error, rate=self.rate, tolerance=self.tolerance)
            yield Stop(patience=body.period)
