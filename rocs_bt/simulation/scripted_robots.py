"""Scripted robots: scripted actors with a robot's body and no agent. They do not yield to other robots."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import Annotated

import numpy as np

from ..base.geometry import Pose2, Twist2, wrap_angle
from ..base.units import NOT_NEGATIVE, Metres, MetresPerSecond, PositiveSeconds, RadiansPerSecond
from ..control.locomotion import Locomotion
from ..declare import Declared, Wrong, has_key
from ..devices.mujoco import MujocoWorld
from ..interfaces.safety_gate import SafetyGate


class ScriptedRobot(Declared, ABC):
    """Script that drives one robot; the annotations of a subclass are the keys of its table in the scenario."""

    def bind(
        self, name: str, world: MujocoWorld, locomotion: Locomotion, motion: SafetyGate, rng: np.random.Generator
    ) -> None:
        """Attach the script to its robot; called once, before the first step.

        Args:
            name: Name of the robot in the world.
            world: World of the robot; a script may use ground truth.
            locomotion: Locomotion of the robot.
            motion: Actuator of the locomotion.
            rng: Random stream of the script.
        """
        self.name = name
        self.world = world
        self.locomotion = locomotion
        self.motion = motion
        self.rng = rng
        self._twist: Twist2 | None = None
        self._values: list[float] = []
        self.begin()

    def begin(self) -> None:
        """Compute what the script needs, such as random values of its `rng`; nothing by default."""

    @abstractmethod
    def twist(self, t: float, pose: Pose2) -> Twist2:
        """Twist for the next control period.

        Args:
            t: Time [s].
            pose: True pose of the robot, world frame.
        """

    def step(self, t: float) -> None:
        """Command the robot for one control period."""
        twist = self.twist(t, self.world.pose(self.name))
        if twist != self._twist:
            self._twist = twist
            self._values = self.locomotion.command(twist).tolist()
        self.motion.command(self._values)


class RandomWalk(ScriptedRobot):
    """Random walk: legs of random speed, curvature and duration, with turns in place between legs and before walls.

    It does not avoid robots.

    Attributes:
        max_speed: Maximum speed of a leg [m/s].
        min_speed: Minimum speed of a leg [m/s].
        in_place_turn_rate: Maximum turn rate in place, between legs [rad/s].
        max_leg_turn_rate: Maximum turn rate along a leg, to either side [rad/s].
        min_leg_duration, max_leg_duration: Minimum and maximum duration of a leg [s].
        margin: Minimum distance of the centre of the drive axle to walls [m].
    """

    max_speed: Annotated[MetresPerSecond, NOT_NEGATIVE] = 0.3
    min_speed: Annotated[MetresPerSecond, NOT_NEGATIVE] = 0.1
    in_place_turn_rate: Annotated[RadiansPerSecond, NOT_NEGATIVE] = 1.0
    max_leg_turn_rate: Annotated[RadiansPerSecond, NOT_NEGATIVE] = 0.3
    min_leg_duration: PositiveSeconds = 1.5
    max_leg_duration: PositiveSeconds = 5.0
    margin: Annotated[Metres, NOT_NEGATIVE] = 0.33

    _AHEAD = 0.15  # [m] distance ahead of the axle at which walls are detected
    _LOOK = 0.6  # [m] distance along a new heading at which there must be space
    _HEADINGS = 16  # number of sampled headings; if none has enough space, the one with the most is taken

    def _check(self) -> Iterator[Wrong]:
        """Faults of minimums above their maximums."""
        for low, high in (("min_speed", "max_speed"), ("min_leg_duration", "max_leg_duration")):
            if getattr(self, low) > getattr(self, high):
                message = f"{low} is {getattr(self, low):g}, and {high} is {getattr(self, high):g}."
                yield Wrong(high if has_key(self, high) else low, message, "A minimum must not exceed its maximum.")

    def begin(self) -> None:
        self._heading = math.nan  # [rad] target of the turn; NaN during a leg
        self._until = 0.0
        self._leg = Twist2(0.0)
        self._look_at = 0.0  # [s] earliest time at which a wall can be too near

    def twist(self, t: float, pose: Pose2) -> Twist2:
        if math.isnan(self._heading) and (t >= self._until or self._walled(t, pose)):
            self._heading = self._choose(pose)
        if math.isnan(self._heading):
            return self._leg
        error = wrap_angle(self._heading - pose.yaw)
        if abs(error) > 0.08:
            rate = min(max(2.0 * error, -self.in_place_turn_rate), self.in_place_turn_rate)
            return Twist2(0.0, rate)
        self._heading = math.nan
        self._look_at = t
        self._until = t + self.rng.uniform(self.min_leg_duration, self.max_leg_duration)
        bend = self.rng.uniform(-self.max_leg_turn_rate, self.max_leg_turn_rate)
        self._leg = Twist2(self.rng.uniform(self.min_speed, self.max_speed), bend)
        return self._leg

    def _walled(self, t: float, pose: Pose2) -> bool:
        if t < self._look_at:
            return False
        spare = self._room(pose, pose.yaw, self._AHEAD) - self.margin
        self._look_at = t + spare / (self.max_speed + self._AHEAD * self.max_leg_turn_rate)
        return spare < 0.0

    def _choose(self, pose: Pose2) -> float:
        """Sample headings; returns the first one with enough space, or else the one with the most space [rad]."""
        headings = self.rng.uniform(-math.pi, math.pi, self._HEADINGS).tolist()
        rooms = [self._room(pose, heading, self._LOOK) for heading in headings]
        for heading, room in zip(headings, rooms, strict=True):
            if room > 1.2 * self.margin:
                return float(heading)
        return float(headings[int(np.argmax(rooms))])

    def _room(self, pose: Pose2, heading: float, ahead: float) -> float:
        return self.world.room(pose.x + ahead * math.cos(heading), pose.y + ahead * math.sin(heading))
