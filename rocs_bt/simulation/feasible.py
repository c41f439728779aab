"""Whether a goal can be reached at all: a pose there at which the robot touches nothing."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from ..device import Reading, Sensor
from ..drivers.mujoco import MujocoWorld
from ..geometry import Pose2

_RINGS = (0.0, 0.5, 0.99)  # of the tolerance
_BEARINGS = 8
_HEADINGS = 24

POSES_TRIED = (1 + (len(_RINGS) - 1) * _BEARINGS) * _HEADINGS
"""How many poses `free_goal_poses` looks at."""


@dataclass(frozen=True)
class FreePose:
    """A pose at a goal at which the robot is free.

    Attributes:
        pose: Where, world frame.
        clearance: From its hull to the nearest thing [m], up to 1 m.
        nearest: What that is; empty when nothing is within 1 m.
        readings: What the robot's sensors say there, by name.
    """

    pose: Pose2
    clearance: float
    nearest: str
    readings: Mapping[str, Reading]


def free_goal_poses(
    world: MujocoWorld,
    robot: str,
    goal: Pose2,
    tolerance: float,
    sensors: Mapping[str, Sensor] | None = None,
    *,
    margin: float = 0.0,
) -> list[FreePose]:
    """The poses within a goal's tolerance, of a fixed fan of them, at which a robot touches nothing.

    The robot is moved: use a world that is made for this, with nobody else in it.

    Args:
        world: The world.
        robot: The robot's name in it.
        goal: The goal; its yaw does not matter.
        tolerance: Of the goal [m].
        sensors: The robot's, to be read at each free pose.
        margin: Clearance that counts as free [m].
    """
    places = [goal]
    for ring in _RINGS[1:]:
        for i in range(_BEARINGS):
            bearing = math.tau * i / _BEARINGS
            reach = ring * tolerance
            places.append(Pose2(goal.x + reach * math.cos(bearing), goal.y + reach * math.sin(bearing)))
    found = []
    for place in places:
        for i in range(_HEADINGS):
            pose = Pose2(place.x, place.y, math.remainder(math.tau * i / _HEADINGS, math.tau))
            world.place(robot, pose)
            clearance, nearest = world.clearance(robot, limit=1.0)
            if clearance > margin:
                readings = {name: sensor.read() for name, sensor in (sensors or {}).items()}
                found.append(FreePose(pose, clearance, nearest, readings))
    return found
