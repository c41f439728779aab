"""Movers: robots that follow a script, have no mind and yield to nobody."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..control.drive import Drive
from ..drivers import read_parameters
from ..drivers.mujoco import MujocoWorld
from ..errors import Fault, InputError, UnknownName, unknown
from ..geometry import Pose2, Twist2, wrap_angle
from ..safety import SafetyGate
from ..units import Metres, MetresPerSecond, RadiansPerSecond, Seconds


class Mover(ABC):
    """A script that moves one robot.

    Args:
        name: The robot in the world.
        world: Where it is; a script may look at the truth.
        drive: What its wheels do.
        wheels: The actuator that takes rim speeds.
        rng: Its own random stream.
    """

    def __init__(
        self, name: str, world: MujocoWorld, drive: Drive, wheels: SafetyGate, rng: np.random.Generator
    ) -> None:
        self.name = name
        self.world = world
        self.drive = drive
        self.wheels = wheels
        self.rng = rng
        self._asked: Twist2 | None = None
        self._speeds: list[float] = []

    @abstractmethod
    def twist(self, t: float, pose: Pose2) -> Twist2:
        """How to move during the next control period.

        Args:
            t: The time [s].
            pose: Where the robot is.
        """

    def step(self, t: float) -> None:
        """Command the wheels for one control period."""
        twist = self.twist(t, self.world.pose(self.name))
        if twist != self._asked:
            self._asked = twist
            self._speeds = self.drive.wheel_speeds(twist).tolist()
        self.wheels.command(self._speeds)


@dataclass(frozen=True, kw_only=True)
class RandomWalkParameters:
    """What random_walk takes.

    Attributes:
        max_speed: The fastest leg [m/s].
        min_speed: The slowest leg [m/s].
        turn_rate: On the spot, between legs [rad/s].
        max_bend: The most that a leg bends to a side [rad/s].
        min_leg, max_leg: How long a leg takes [s].
        margin: How far from walls its axle stays [m].
    """

    max_speed: MetresPerSecond = 0.3
    min_speed: MetresPerSecond = 0.1
    turn_rate: RadiansPerSecond = 1.0
    max_bend: RadiansPerSecond = 0.3
    min_leg: Seconds = 1.5
    max_leg: Seconds = 5.0
    margin: Metres = 0.33

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not 0.0 <= value < math.inf:
                raise InputError(Fault(f"{name} must be finite and no less than zero, found {value:g}."))
        if not self.min_speed <= self.max_speed or not 0.0 < self.min_leg <= self.max_leg:
            raise InputError(
                Fault(
                    f"speeds and legs must be given as a least and a greatest one, found {self.min_speed} to "
                    f"{self.max_speed} m/s and {self.min_leg} to {self.max_leg} s."
                )
            )


class RandomWalk(Mover):
    """Legs of random speed, bend and length; turns on the spot between them and before walls, never for robots."""

    Parameters = RandomWalkParameters
    _AHEAD = 0.15  # [m] in front of the axle, where it looks for walls
    _LOOK = 0.6  # [m] along a new heading, which must be free
    _HEADINGS = 16  # that it draws before it takes the freest

    def __init__(self, *args: Any, parameters: RandomWalkParameters) -> None:
        super().__init__(*args)
        self._p = parameters
        self._heading = math.nan  # [rad] that it turns to; NaN while it drives a leg
        self._until = 0.0
        self._leg = Twist2(0.0)
        self._look_at = 0.0  # [s] until when no wall can have come too near

    def twist(self, t: float, pose: Pose2) -> Twist2:
        if math.isnan(self._heading) and (t >= self._until or self._walled(t, pose)):
            self._heading = self._choose(pose)
        if math.isnan(self._heading):
            return self._leg
        error = wrap_angle(self._heading - pose.yaw)
        if abs(error) > 0.08:
            rate = min(max(2.0 * error, -self._p.turn_rate), self._p.turn_rate)
            return Twist2(0.0, rate)
        self._heading = math.nan
        self._look_at = t
        self._until = t + self.rng.uniform(self._p.min_leg, self._p.max_leg)
        bend = self.rng.uniform(-self._p.max_bend, self._p.max_bend)
        self._leg = Twist2(self.rng.uniform(self._p.min_speed, self._p.max_speed), bend)
        return self._leg

    def _walled(self, t: float, pose: Pose2) -> bool:
        if t < self._look_at:
            return False
        spare = self._room(pose, pose.yaw, self._AHEAD) - self._p.margin
        self._look_at = t + spare / (self._p.max_speed + self._AHEAD * self._p.max_bend)
        return spare < 0.0

    def _choose(self, pose: Pose2) -> float:
        """The first random heading that leads somewhere, or else the freest of them [rad]."""
        headings = self.rng.uniform(-math.pi, math.pi, self._HEADINGS).tolist()
        rooms = [self._room(pose, heading, self._LOOK) for heading in headings]
        for heading, room in zip(headings, rooms, strict=True):
            if room > 1.2 * self._p.margin:
                return float(heading)
        return float(headings[int(np.argmax(rooms))])

    def _room(self, pose: Pose2, heading: float, ahead: float) -> float:
        return self.world.room(pose.x + ahead * math.cos(heading), pose.y + ahead * math.sin(heading))


MOVERS: Mapping[str, type[RandomWalk]] = {"random_walk": RandomWalk}


def make_mover(
    script: str,
    parameters: Mapping[str, Any],
    *,
    name: str,
    world: MujocoWorld,
    drive: Drive,
    wheels: SafetyGate,
    rng: np.random.Generator,
) -> Mover:
    """A mover by its script's name.

    Raises:
        InputError: No such script, or parameters that do not fit it; with every fault.
    """
    if script not in MOVERS:
        raise UnknownName(unknown("mover script", script, MOVERS))
    cls = MOVERS[script]
    wanted = read_parameters(cls.Parameters, parameters, f"{script} '{name}'")
    return cls(name, world, drive, wheels, rng, parameters=wanted)
