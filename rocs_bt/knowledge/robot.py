"""The RobotModel: what the robot knows of its own body (paper, 4.2 and 5.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..errors import Fault, InputError, KnowledgeError
from ..geometry import Pose2, Twist2, pose2
from .base import KnowledgeBase
from .model import Model
from .signals import Array

if TYPE_CHECKING:  # the drive is given by the agent: at run time every arrow points down
    from ..control.drive import Drive


@dataclass(frozen=True)
class Scanner:
    """How a laser scanner looks.

    Attributes:
        rays: Of one scan, evenly spread, from the right to the left.
        span: From the first ray to the last [rad].
        mount: Where they begin, and where the middle one points, in the body frame.
    """

    rays: int
    span: float
    mount: Pose2

    @cached_property
    def bearings(self) -> Array:
        """(rays,) Where each ray points, from the mount's axis, left positive [rad]."""
        return np.linspace(-0.5 * self.span, 0.5 * self.span, self.rays)


class RobotModel(Model):
    """Structure, sensors, actuators, limits, present state, and kinematics both ways.

    The present state is read from the standard signals `pose`, `wheel_speeds`, `speed` and `turn_rate`; NaN where one
    is not valid, or where the robot has no sensor for it. Times are in seconds, now where None.
    """

    def __init__(self, knowledge: KnowledgeBase) -> None:
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
        x, y, yaw = self.signals.numbers("pose", self._time(t))
        return pose2((x, y, yaw))

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

    def twist(self, t: float | None = None) -> Twist2:
        """How it moves by `speed` and `turn_rate`, what it skids sideways in a turn included, in the body frame."""
        turn = self.turn_rate(t)
        return Twist2(self.speed(t), turn, -self.pivot * turn)

    @property
    def pivot(self) -> float:
        """How far ahead of its base the place lies that moves only along its heading [m]; 0 while it has no drive."""
        return 0.0 if self._drive is None else self._drive.pivot

    def inverse(self, twist: Twist2) -> Array:
        """The rim speeds that make a twist, shape (wheels,) [m/s]."""
        return self.drive.wheel_speeds(twist)

    def forward(self, wheel_speeds: Array) -> Twist2:
        """The twist that rim speeds [m/s] make."""
        return self.drive.twist(wheel_speeds)

    def sensors(self) -> list[str]:
        """The names of its sensors."""
        return self.graph.related(self.name, "has_sensor")

    def scanner(self, signal: str) -> Scanner:
        """The scanner whose ranges a signal holds.

        Raises:
            InputError: No sensor does, or its table in robot.toml does not tell all of how it looks.
        """
        for sensor in self.sensors():
            of, rays, span, mount = (self.graph.get(sensor, key) for key in ("signal", "rays", "span", "mount"))
            if of == signal and rays is not None and span is not None and mount is not None:
                return Scanner(rays, span, mount)
        message = f"no sensor of '{self.name}' has the signal '{signal}' and tells its rays, its span and its mount."
        hint = f'Write into its [[sensor]] table: signal = "{signal}", rays, span, mount = {{ x = "0.12 m" }}.'
        raise InputError(Fault(message, hint=hint))

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
