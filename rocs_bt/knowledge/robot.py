"""RobotModel: knowledge about the robot's own body (paper, 4.2 and 5.1)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from ..base.errors import Fault, InputError, KnowledgeError
from ..base.geometry import Pose2, Twist2, pose2
from ..control.footprint import Footprint
from .base import KnowledgeBase, Model
from .signals import Array

if TYPE_CHECKING:  # the agent passes the locomotion, so that at run time knowledge imports no upper layer
    from ..control.locomotion import Locomotion


@dataclass(frozen=True)
class Scanner:
    """Geometry of a laser scanner.

    Attributes:
        rays: Number of rays in a scan, evenly spaced, from right to left.
        span: Angle between the first and the last ray [rad].
        mount: Pose of the scanner in the body frame; its x axis is the middle ray.
    """

    rays: int
    span: float
    mount: Pose2

    @cached_property
    def bearings(self) -> Array:
        """Bearings of the rays from the mount's x axis, left positive [rad], shape (rays,)."""
        return np.linspace(-0.5 * self.span, 0.5 * self.span, self.rays)


class RobotModel(Model):
    """View of knowledge as the robot: sensors, actuators, limits, present state and kinematics.

    The present state is read from the standard signals `pose`, `wheel_speeds`, `speed` and `turn_rate`. It is NaN if
    a signal is not valid or the robot has no sensor for it. Times are in seconds; None means now.
    """

    def __init__(self, knowledge: KnowledgeBase) -> None:
        super().__init__(knowledge)
        self._locomotion: Locomotion | None = None
        self.blind: frozenset[str] = frozenset()
        """Standard groups without a sensor, such as `rear`; set by the agent."""

    @property
    def locomotion(self) -> Locomotion:
        """Kinematics, limits and response of the body; set by the agent.

        Raises:
            KnowledgeError: The locomotion has not been set.
        """
        if self._locomotion is None:
            raise KnowledgeError(f"the robot '{self.name}' has no locomotion; set `knowledge.robot.locomotion` first.")
        return self._locomotion

    @locomotion.setter
    def locomotion(self, locomotion: Locomotion) -> None:
        self._locomotion = locomotion

    def pose(self, t: float | None = None) -> Pose2:
        """Pose of the robot in the world frame [m, m, rad]; all NaN while unknown."""
        if "pose" not in self.signals:
            return Pose2(math.nan, math.nan, math.nan)
        x, y, yaw = self.signals.numbers("pose", self._time(t))
        return pose2((x, y, yaw))

    def wheel_speeds(self, t: float | None = None) -> Array:
        """Measured wheel linear speeds in the order of `locomotion.wheels` [m/s], shape (wheels,)."""
        if "wheel_speeds" not in self.signals:
            return np.full(len(self.locomotion.wheels), math.nan)
        return self.signals.read("wheel_speeds", self._time(t))

    def motion(self, t: float | None = None) -> Array:
        """Measured values of the motion, as in a motion command, shape (m,): wheel speeds, or components of the twist.

        They are NaN where the robot measures none, except for a lateral speed without a sensor, which counts as 0.
        """
        if self.locomotion.wheels:
            return self.wheel_speeds(t)
        speeds = {"vx": self.speed(t), "vy": self._value("lateral_speed", t, 0.0), "vz": self._value("climb", t)}
        return np.array([speeds.get(axis, self.turn_rate(t)) for axis in self.locomotion.values])

    def speed(self, t: float | None = None) -> float:
        """Forward speed of the centre [m/s]."""
        return self._value("speed", t)

    def height(self, t: float | None = None) -> float:
        """Height in the world frame, from the signal `height` [m]; NaN without this signal and while it is invalid."""
        return self._value("height", t)

    def turn_rate(self, t: float | None = None) -> float:
        """Turn rate, left positive [rad/s]."""
        return self._value("turn_rate", t)

    def twist(self, t: float | None = None) -> Twist2:
        """Body-frame twist from `speed`, `turn_rate` and `lateral_speed`; without the last with the skid in a turn."""
        turn = self.turn_rate(t)
        return Twist2(self.speed(t), turn, self._value("lateral_speed", t, -self.icr_offset * turn))

    @property
    def icr_offset(self) -> float:
        """Forward distance from the base to the point that never moves sideways [m]; 0 without a locomotion."""
        return 0.0 if self._locomotion is None else self._locomotion.icr_offset

    @property
    def axes(self) -> tuple[str, ...]:
        """Axes of the twist that can be commanded, of `vx`, `vy`, `vz` and `wz`; empty without a locomotion."""
        return () if self._locomotion is None else self._locomotion.axes

    @property
    def hull(self) -> Footprint | None:
        """Outline of the robot from the length and width of its [body] table; None if it declares none."""
        known = self.graph.attributes(self.name)
        length, width = known.get("length"), known.get("width")
        return Footprint(length, width) if length and width else None

    def inverse(self, twist: Twist2) -> Array:
        """Values of the motion command that produce a twist, shape (m,); wheel linear speeds [m/s] on wheels."""
        return self.locomotion.command(twist)

    def forward(self, values: Array) -> Twist2:
        """Body-frame twist produced by the values of a motion command, such as wheel linear speeds [m/s]."""
        return self.locomotion.twist(values)

    def sensors(self) -> list[str]:
        """Names of the robot's sensors."""
        return self.graph.related(self.name, "has_sensor")

    def scanner(self, signal: str) -> Scanner:
        """Geometry of the scanner that writes a signal.

        Raises:
            InputError: No sensor has this signal with `rays`, `span` and `mount` in its table in robot.toml.
        """
        for sensor in self.sensors():
            of, rays, span, mount = (self.graph.get(sensor, key) for key in ("signal", "rays", "span", "mount"))
            if of == signal and rays is not None and span is not None and mount is not None:
                return Scanner(rays, span, mount)
        message = f"no sensor of '{self.name}' has the signal '{signal}' and declares rays, span and mount."
        hint = f'Write into its [[sensor]] table: signal = "{signal}", rays, span, mount = {{ x = "0.12 m" }}.'
        raise InputError(Fault(message, hint=hint))

    def actuators(self) -> list[str]:
        """Names of the robot's actuators."""
        return self.graph.related(self.name, "has_actuator")

    @property
    def limits(self) -> Mapping[str, float]:
        """All known limits of the robot, by name, SI units."""
        return {n: v for n, v in self.graph.attributes(self.name).items() if n.endswith("_limit")}

    def _value(self, signal: str, t: float | None, default: float = math.nan) -> float:
        return self.signals.value(signal, self._time(t)) if signal in self.signals else default

    def _time(self, t: float | None) -> float:
        return self.knowledge.clock.now() if t is None else t
