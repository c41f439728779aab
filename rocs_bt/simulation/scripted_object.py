"""ScriptedObject: base class of the scripts that move objects of the world, such as doors and people."""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from ..base.geometry import Pose2
from ..declare import Declared
from ..devices.mujoco import MujocoWorld, Near

Vector = tuple[float, float]

_PRESSED = 1e-3
"""Overlap with a robot at which an object stops [m]: a touch, which the world reports."""


_AWAY = 0.05
"""Gap from which an object has moved away from a robot that it touched [m]."""


class ScriptedObject(Declared, ABC):
    """Script that moves one object; the annotations of a subclass are the keys of its table in the scenario."""

    def bind(
        self, name: str, world: MujocoWorld, start: Pose2, rng: np.random.Generator, control_period: float
    ) -> None:
        """Attach the script to its object, and place it at its start; called once, before the first step.

        Args:
            name: Name of the object in the world.
            world: The world; a script may read ground truth.
            start: Start pose, world frame.
            rng: Random stream of the script.
            control_period: Control period [s].
        """
        self.name = name
        self.world = world
        self.start = start
        self.rng = rng
        self.control_period = control_period
        self._touched: set[str] = set()  # robots that it touched, and from which it has not moved away
        world.place_object(name, start)
        self.begin()

    def begin(self) -> None:
        """Compute what the script needs, such as random values of its `rng`; nothing by default."""

    @property
    def states(self) -> dict[str, Pose2]:
        """Poses of the object that have a name, such as `open`; none by default."""
        return {}

    @abstractmethod
    def velocity(self, t: float, at: Vector) -> Vector:
        """Velocity of the object for the next control period [m/s], world frame.

        Args:
            t: Time [s].
            at: Position of the object [m], world frame.
        """

    def step(self, t: float) -> None:
        """Set the velocity for one control period."""
        pose = self.world.object_pose(self.name)
        self.world.set_object_velocity(self.name, self._stopped(self.velocity(t, (pose.x, pose.y))))

    def _stopped(self, velocity: Vector) -> Vector:
        """The part of a velocity that pushes into no robot [m/s]: an object stops at what it touches."""
        wish = np.array(velocity)
        for near in self._near(float(np.hypot(*wish)) * self.control_period):
            wish -= max(float(wish @ near.direction) - self._room(near) / self.control_period, 0.0) * near.direction
        return float(wish[0]), float(wish[1])

    def _stopped_turn(self, rate: float) -> float:
        """The part of a turn rate that pushes into no robot [rad/s]."""
        pose = self.world.object_pose(self.name)
        for near in self._near(1.0):
            x, y = near.point - (pose.x, pose.y)
            way = rate * self.control_period * float(near.direction @ (-y, x))  # [m] towards the robot
            if way > 0.0:
                rate *= min(self._room(near) / way, 1.0)
        return rate

    def _near(self, reach: float) -> list[Near]:
        near = self.world.around(self.name, max(reach, _AWAY), objects=False)
        self._touched = {robot.name for robot in near if robot.name in self._touched or robot.gap <= 0.0}
        return near

    def _room(self, robot: Near) -> float:
        """Way to a robot [m]. The world reports a touch if the two overlap; to overlap it again would push it."""
        return max(robot.gap + (0.0 if robot.name in self._touched else _PRESSED), 0.0)

    def towards(self, at: Vector, target: Vector) -> Vector:
        """Velocity [m/s] that moves the object from `at` to `target` [m] within one control period."""
        return (target[0] - at[0]) / self.control_period, (target[1] - at[1]) / self.control_period
