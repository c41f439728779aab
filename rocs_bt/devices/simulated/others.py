"""Sensors of other robots, of their messages, and of the battery."""

from __future__ import annotations

import math
from typing import Annotated, ClassVar

from ...base.errors import InputError
from ...base.geometry import wrap_angle
from ...base.units import ANGLE, LENGTH, NOT_NEGATIVE, POSITIVE, Bounds, Joules, PositiveMetres, Watts
from ...interfaces.device import Reading
from ...interfaces.message import MessageQueue, packed
from .device import SimulatedSensor
from .pose import AngleNoise, Distance, Share
from .ranges import Count

_Power = Annotated[Watts, NOT_NEGATIVE]
_EMPTY_SLOT = (0.0, math.inf, 0.0)
_MOVING = 0.02  # [m/s], [rad/s]


class RobotSensor(SimulatedSensor):
    """Robot sensor, which detects other robots: tag, range [m] and bearing [rad] for each slot, nearest first.

    A tag identifies a robot; tags are numbers from 1, in the order of the robots in the world. Ranges and bearings
    (left positive) are measured between the centres of the bases. An empty slot has tag 0, range +inf and bearing 0,
    which are valid values.

    Attributes:
        max_range: Maximum range [m].
        max_peers: Maximum number of robots in a reading, which contains the nearest ones.
        half_angle: Half the field of view, centred ahead [rad].
        range_noise: Standard deviation of a range [m].
        bearing_noise: Standard deviation of a bearing [rad].
        height: Height of the line of sight over the floor [m]; lower obstacles do not hide a robot.
    """

    max_range: Annotated[float, LENGTH, Bounds(0.0, above=True, infinite=True)]
    max_peers: Count = 4
    half_angle: Annotated[float, ANGLE, Bounds(0.0, math.pi, above=True)] = math.pi
    range_noise: Distance = 0.0
    bearing_noise: AngleNoise = 0.0
    height: PositiveMetres = 0.2

    @property
    def size(self) -> int:
        """Number of values of a reading."""
        return 3 * self.max_peers

    def set_up(self) -> None:
        if self.noise > 0.0:
            raise InputError(f"robot_sensor '{self.name}' does not take 'noise'. Use range_noise and bearing_noise.")
        self._others = {tag: other for tag, other in enumerate(self.world.robots, 1) if other != self.robot}

    def sample(self) -> list[float]:
        world, here = self.world, self.world.pose(self.robot)
        # For all robots, so that the noise of one does not depend on the visibility of another.
        errors, found = self.rng.standard_normal((len(self._others), 2)).tolist(), []
        for (tag, other), (range_error, bearing_error) in zip(self._others.items(), errors, strict=True):
            there = world.pose(other)
            distance, bearing = here.distance(there), here.bearing(there)
            in_view = distance <= self.max_range and abs(bearing) <= self.half_angle
            if in_view and world.sees(self.robot, other, self.height):
                bearing = wrap_angle(bearing + self.bearing_noise * bearing_error)
                found.append((float(tag), max(0.0, distance + self.range_noise * range_error), bearing))
        found.sort(key=lambda sighting: sighting[1])
        slots = (found + [_EMPTY_SLOT] * self.max_peers)[: self.max_peers]
        return [value for slot in slots for value in slot]


class MailboxSensor(SimulatedSensor):
    """Mailbox: messages of other robots since the last reading, as the bytes of sender and text; it may be empty."""

    size: ClassVar[int | None] = None

    def set_up(self) -> None:
        self.message_queue = MessageQueue()

    def read(self) -> Reading:
        return Reading(self.world.stamp, self.sample())  # messages are read once, also of a world that does not step

    def sample(self) -> list[float]:
        return packed(self.message_queue.take())


class Battery(SimulatedSensor):
    """Battery: charge, 0 (empty) to 1 (full). An empty battery does not stop the motors.

    Attributes:
        capacity: Energy of the full battery [J].
        idle_power: Power that is always drawn [W].
        motion_power: Power that is drawn in addition while the body moves [W].
        charge_power: Power with which the battery is charged at a charger [W].
        chargers: Names of the places of a scenario at which the battery is charged; other names have no effect.
        charge_distance: Distance between the robot's base and a charger within which the battery is charged [m].
        charge: Charge at the start, 0 to 1.
    """

    size: ClassVar[int] = 1
    capacity: Annotated[Joules, POSITIVE]
    idle_power: _Power
    motion_power: _Power = 0.0
    charge_power: _Power = 0.0
    chargers: tuple[str, ...] = ("charger",)
    charge_distance: PositiveMetres = 0.3
    charge: Share = 1.0

    def set_up(self) -> None:
        self._at, self._left = self.world.stamp, self.charge
        self._chargers = [self.world.places[name] for name in self.chargers if name in self.world.places]

    def sample(self) -> list[float]:
        """Charge; the power since the last reading is that of the present pose and motion."""
        pose, twist = self.world.pose(self.robot), self.world.twist3(self.robot)
        seconds, self._at = self.world.stamp - self._at, self.world.stamp
        power = -self.idle_power
        if max(math.hypot(twist.forward, twist.left), abs(twist.up), abs(twist.turn)) > _MOVING:
            power -= self.motion_power
        if any(pose.distance(charger) <= self.charge_distance for charger in self._chargers):
            power += self.charge_power
        self._left = min(1.0, max(0.0, self._left + power * seconds / self.capacity))
        return [self._left]

    def limit(self, values: list[float]) -> list[float]:
        return [min(1.0, max(0.0, value)) for value in values]
