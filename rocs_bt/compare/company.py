"""Company: distances and times to collision between a robot and all that moves around it."""

from __future__ import annotations

import math

import numpy as np

from ..devices.mujoco import MujocoWorld
from ..simulation import ScriptedObject, ScriptedRobot, SimulatedWorld

INTIMATE, PERSONAL = 0.45, 1.2
"""Extent of the intimate and the personal space of a person [m] (Hall, The Hidden Dimension, 1966)."""

_SIGHT = 5.0  # [m] gap beyond which others are ignored


class Company:
    """What moves around a robot, measured once a control period against ground truth.

    Distances are gaps between the hull and the outline of the other.

    Attributes:
        moved: Whether anything but the robot moves in this world.
        time_to_collision: Minimum of gap divided by closing speed so far [s]; +inf if nothing came closer.
    """

    def __init__(self, robot: str, simulated: SimulatedWorld) -> None:
        self.time_to_collision = math.inf
        self._robot = robot
        self._world: MujocoWorld = simulated.world
        scripted = {actor.name for actor in simulated.actors if isinstance(actor, ScriptedObject | ScriptedRobot)}
        self._others = (scripted | set(self._world.robots)) - {robot}
        self.moved = bool(self._others)
        self._nearest: list[float] = []

    def measure(self) -> None:
        """Measure one control period."""
        nearest = math.inf
        for near in self._world.around(self._robot, _SIGHT) if self.moved else ():
            if near.name in self._others:
                nearest = min(nearest, near.gap)
                approach = self._world.velocity(self._robot, near.point) - self._world.velocity(near.name, near.point)
                closing = float(approach @ near.direction)
                if closing > 0.0:
                    self.time_to_collision = min(self.time_to_collision, max(near.gap, 0.0) / closing)
        self._nearest.append(nearest)

    def intrusion(self, extent: float) -> float | None:
        """Share of the time in which something that moves was nearer than an extent [m]; None if nothing moves."""
        if not self.moved or not self._nearest:
            return None
        return float(np.mean(np.array(self._nearest) < extent))
