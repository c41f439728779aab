"""Feasibility of a goal: sampled poses near it at which the robot is free of collisions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from ..base.geometry import Pose2
from ..devices.mujoco import MujocoSensor, MujocoWorld
from ..interfaces.device import Reading, Sensor

_RINGS = (0.0, 0.5, 0.99)  # radii of the rings of tried positions, as shares of the goal's tolerance
_BEARINGS = 8
_HEADINGS = 24

POSES_TRIED = (1 + (len(_RINGS) - 1) * _BEARINGS) * _HEADINGS
"""Number of poses that `free_goal_poses` checks."""


@dataclass(frozen=True)
class FreePose:
    """Collision-free pose of a robot at a goal.

    Attributes:
        pose: Pose, world frame.
        clearance: Distance from the hull to the nearest obstacle [m]; 1 m if it is farther.
        nearest: Name of the nearest obstacle; empty if none is within 1 m.
        readings: Readings of the robot's sensors at the pose, by sensor.
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
    height: float | None = None,
    margin: float = 0.0,
) -> Iterator[FreePose]:
    """Collision-free poses of a robot within a goal's tolerance, from a fixed grid of `POSES_TRIED` poses.

    Each pose is checked when it is asked for; the robot is then at this pose.

    The function moves the robot: use a world made for this purpose, without other robots.

    Args:
        world: The world.
        robot: Name of the robot.
        goal: Goal pose, world frame; its yaw is ignored.
        tolerance: Position tolerance of the goal [m].
        sensors: Sensors of the robot, read at each free pose; None reads none.
        height: Height of the base, world frame [m]; by default that of the robot's model over the ground.
        margin: Minimum clearance of a free pose [m], exclusive.
    """
    places = [goal]
    for ring in _RINGS[1:]:
        for i in range(_BEARINGS):
            bearing = math.tau * i / _BEARINGS
            reach = ring * tolerance
            places.append(Pose2(goal.x + reach * math.cos(bearing), goal.y + reach * math.sin(bearing)))
    for place in places:
        for i in range(_HEADINGS):
            pose = Pose2(place.x, place.y, math.remainder(math.tau * i / _HEADINGS, math.tau))
            world.place(robot, pose, height)
            clearance, nearest = world.clearance(robot, limit=1.0)
            if clearance > margin:
                readings = {name: _measured(sensor) for name, sensor in (sensors or {}).items()}
                yield FreePose(pose, clearance, nearest, readings)


def _measured(sensor: Sensor) -> Reading:
    """Reading of a sensor at the present pose, also if its readings arrive late."""
    return sensor.measure() if isinstance(sensor, MujocoSensor) else sensor.read()
