"""The RobotModel: what the robot knows of its own body (paper, 4.2 and 5.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ..errors import KnowledgeError
from ..geometry import Pose2, Twist2
from .model import Model
from .signals import Array

if TYPE_CHECKING:  # the drive is given by the agent: at run time every arrow points down
    from ..control.drive import Drive
    from .knowledge import Knowledge


class RobotModel(Model):
    """Structure, sensors, actuators, limits, present state, and kinematics both ways.

    The present state is read from the standard signals `pose`, `wheel_speeds`, `speed` and `turn_rate`; NaN where one
    is not valid, or where the robot has no sensor for it. Times are in seconds, now where None.
    """

    def __init__(self, knowledge: Knowledge) -> None:
        super().__init__(knowledge)
        self._drive: Drive | None = None

    @property
    def drive(self) -> Drive:
        """Kinematics and limits of the wheels; given by the agent.

        Raises:
            KnowledgeError: Nobody gave it.
        """
        if self._drive is None:
            raise KnowledgeError(f"the robot '{self.name}' has no drive; set `knowledge.robot.drive` first.")
        return self._drive

    @drive.setter
    def drive(self, drive: Drive) -> None:
        self._drive = drive

    def pose(self, t: float | None = None) -> Pose2:
        """Where the robot is, in the world frame [m, m, rad]; all NaN while it is not known."""
        if "pose" not in self.signals:
            return Pose2(math.nan, math.nan, math.nan)
        return Pose2(*self.signals.read("pose", self._time(t)).tolist())

    def wheel_speeds(self, t: float | None = None) -> Array:
        """Measured rim speeds in the drive's order, shape (wheels,) [m/s]."""
        if "wheel_speeds" not in self.signals:
            return np.full(len(self.drive.wheels), math.nan)
        return self.signals.read("wheel_speeds", self._time(t))

    def speed(self, t: float | None = None) -> float:
        """Forward speed of the centre [m/s]."""
        return self._value("speed", t)

    def turn_rate(self, t: float | None = None) -> float:
        """Turn rate, left positive [rad/s]."""
        return self._value("turn_rate", t)

    def inverse(self, twist: Twist2) -> Array:
        """The rim speeds that make a twist, shape (wheels,) [m/s]."""
        return self.drive.wheel_speeds(twist)

    def forward(self, wheel_speeds: Array) -> Twist2:
        """The twist that rim speeds [m/s] make."""
        return self.drive.twist(wheel_speeds)

    def sensors(self) -> list[str]:
        """The names of its sensors."""
        return self.graph.related(self.name, "has_sensor")

    def actuators(self) -> list[str]:
        """The names of its actuators."""
        return self.graph.related(self.name, "has_actuator")

    @property
    def limits(self) -> Mapping[str, float]:
        """Every limit that is known of the robot, by name, SI units."""
        return {n: v for n, v in self.graph.attributes(self.name).items() if n.endswith("_limit")}

    def _value(self, signal: str, t: float | None) -> float:
        return self.signals.value(signal, self._time(t)) if signal in self.signals else math.nan

    def _time(self, t: float | None) -> float:
        return self.knowledge.clock.now() if t is None else t
