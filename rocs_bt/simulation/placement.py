"""Start poses of robots: the scenario's poses with random offsets by seed, free of collisions."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2, wrap_angle
from ..declare import location_of
from ..devices.mujoco import MujocoWorld
from .random_streams import START, stream

_SAMPLES = 20  # number of sampled poses, all in collision, after which a start counts as impossible
_REST = 5e-3  # [m] depth in the floor up to which a hull rests on it


class Start(Protocol):
    """Start pose of an agent or actor."""

    @property
    def name(self) -> str:
        """Name of the robot in the world."""

    @property
    def pose(self) -> Pose2:
        """Nominal start pose, world frame."""

    @property
    def jitter(self) -> Pose2:
        """Half-widths of the uniform distribution of the start pose: x, y [m], yaw [rad]."""


def place_all(world: MujocoWorld, starts: Sequence[Start], scenario: str, seed: int) -> dict[str, Pose2]:
    """Place every robot at a sampled start pose; poses in collision are sampled again.

    Args:
        world: World of the robots.
        starts: Starts of all robots in the world.
        scenario: Name of the scenario, which seeds the random streams.
        seed: Seed of the episode.

    Returns:
        Start poses by robot, world frame.

    Raises:
        InputError: A start is outside of the world, in collision, or inside the floor; lists every such start.
    """
    poses, faults = {}, [fault for start in starts if (fault := _outside(world, start)) is not None]
    if faults:
        raise InputError(*faults)
    # Move all robots far away first, so that robots without a pose yet do not block others.
    for i, start in enumerate(starts):
        world.place(start.name, Pose2(1e4 + 10.0 * i, 1e4))
    for start in starts:
        rng = stream(scenario, seed, start.name, START)
        for _ in range(_SAMPLES):
            pose = jittered(start.pose, start.jitter, rng)
            world.place(start.name, pose)
            distance, obstacle = world.clearance(start.name, limit=1e-6)
            if not obstacle:
                break
        else:
            faults.append(_inside(start, pose, distance, obstacle))
        depth, geom, floor = world.sunk(start.name)
        if depth > _REST:
            faults.append(_sunk(start, depth, geom, floor))
        poses[start.name] = pose
    if faults:
        raise InputError(*faults)
    return poses


def jittered(pose: Pose2, jitter: Pose2, rng: np.random.Generator) -> Pose2:
    """Sample a pose from the uniform distribution around `pose` with the half-widths `jitter`."""
    x, y, yaw = rng.uniform(-1.0, 1.0, 3).tolist()
    return Pose2(pose.x + x * jitter.x, pose.y + y * jitter.y, wrap_angle(pose.yaw + yaw * jitter.yaw))


def _outside(world: MujocoWorld, start: Start) -> Fault | None:
    """Fault of a start outside of the bounding box of the static world; None if it is inside."""
    left, low, right, high = world.bounds()
    if left <= start.pose.x <= right and low <= start.pose.y <= high:
        return None
    return Fault(
        f"the start of {start.name} at x = {start.pose.x:g} m, y = {start.pose.y:g} m is outside of the world, which "
        f"goes from x = {left:.3g} to {right:.3g} m and from y = {low:.3g} to {high:.3g} m.",
        line=location_of(start).line,
        hint="Move it inside.",
    )


def _inside(start: Start, pose: Pose2, distance: float, obstacle: str) -> Fault:
    return Fault(
        f"{start.name} cannot start at x = {pose.x:.2f} m, y = {pose.y:.2f} m, yaw = {math.degrees(pose.yaw):.0f} deg: "
        f"its hull would be {max(-distance, 0.0):.2f} m inside '{obstacle}'.",
        line=location_of(start).line,
        hint="Move its start, or reduce its jitter.",
    )


def _sunk(start: Start, depth: float, geom: str, floor: str) -> Fault:
    return Fault(
        f"{start.name} cannot start: its geom '{geom}' would begin {1e3 * depth:.0f} mm inside '{floor}'.",
        line=location_of(start).line,
        hint="Raise the base in its model, or use a world with a lower floor.",
    )
