"""Where robots start: the scenario's poses, moved by the seed, with nobody inside of anything."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Protocol

import numpy as np

from ..drivers.mujoco import MujocoWorld
from ..errors import Fault, InputError
from ..geometry import Pose2, wrap_angle
from .random_streams import START, stream

_DRAWS = 20  # until a start is called impossible


class Start(Protocol):
    """What placement needs of an agent or a mover of a scenario."""

    @property
    def name(self) -> str:
        """The robot's name in the world."""
        ...

    @property
    def pose(self) -> Pose2:
        """Where it starts, before the seed moves it."""
        ...

    @property
    def line(self) -> int:
        """Where it stands in the scenario's file."""
        ...

    @property
    def jitter(self) -> Pose2:
        """Half-widths of the uniform draw."""
        ...


def place_all(world: MujocoWorld, starts: Sequence[Start], scenario: str, seed: int) -> dict[str, Pose2]:
    """Put every robot at its start, drawn anew while it is inside of something.

    Args:
        world: The world; all its robots are placed.
        starts: Where they start.
        scenario: Name of the scenario, which keys the draws.
        seed: The episode's seed.

    Returns:
        The poses by robot.

    Raises:
        InputError: A robot cannot be at its start: it is outside of the world, or inside of something; for each one.
    """
    poses, faults = {}, [fault for start in starts if (fault := _outside(world, start)) is not None]
    if faults:
        raise InputError(*faults)
    # Out of each other's way first: those that are not placed yet must not block those that are.
    for i, start in enumerate(starts):
        world.place(start.name, Pose2(1e4 + 10.0 * i, 1e4))
    for start in starts:
        rng = stream(scenario, seed, start.name, START)
        for _ in range(_DRAWS):
            pose = jittered(start.pose, start.jitter, rng)
            world.place(start.name, pose)
            distance, thing = world.clearance(start.name, limit=1e-6)
            if not thing:
                break
        else:
            faults.append(_inside(start, pose, distance, thing))
        poses[start.name] = pose
    if faults:
        raise InputError(*faults)
    return poses


def jittered(pose: Pose2, jitter: Pose2, rng: np.random.Generator) -> Pose2:
    """The pose, moved by three uniform draws within the half-widths of `jitter`."""
    x, y, yaw = rng.uniform(-1.0, 1.0, 3).tolist()
    return Pose2(pose.x + x * jitter.x, pose.y + y * jitter.y, wrap_angle(pose.yaw + yaw * jitter.yaw))


def _outside(world: MujocoWorld, start: Start) -> Fault | None:
    """The fault of a start beyond all that is in the world and cannot move; None for none."""
    left, low, right, high = world.bounds()
    if left <= start.pose.x <= right and low <= start.pose.y <= high:
        return None
    return Fault(
        f"the start of {start.name} at x = {start.pose.x:g} m, y = {start.pose.y:g} m is outside of the world, which "
        f"goes from x = {left:.3g} to {right:.3g} m and from y = {low:.3g} to {high:.3g} m.",
        line=start.line,
        hint="Move it inside.",
    )


def _inside(start: Start, pose: Pose2, distance: float, thing: str) -> Fault:
    return Fault(
        f"{start.name} cannot start at x = {pose.x:.2f} m, y = {pose.y:.2f} m, yaw = {math.degrees(pose.yaw):.0f} deg: "
        f"its hull would be {max(-distance, 0.0):.2f} m inside '{thing}'.",
        line=start.line,
        hint="Move its start, or make its jitter smaller.",
    )
