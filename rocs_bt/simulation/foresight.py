"""Foresight: the true motion of people over the next seconds, which only oracle planners get."""

from __future__ import annotations

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from ..base.geometry import Pose2
from ..control.prediction import Prediction
from ..devices.mujoco import MujocoWorld
from ..devices.mujoco.ghost import GhostWorld
from ..knowledge import Movers, WorldModel
from ..knowledge.signals import Array
from .scripted_object import ScriptedObject

HORIZON = 4.2
"""Time for which motion is foreseen [s]: a plan of FollowRoute with its delay. Later, movers stay where they are."""

EVERY = 0.1
"""Time between two looks into the future [s]."""


@dataclass(frozen=True, eq=False)
class Foreseen(Movers):
    """Movers with a known future.

    Attributes:
        times: Times of the positions, ascending, shape (k,) [s].
        positions: Positions at these times, world frame, shape (n, k, 2) [m].
    """

    times: Array
    positions: Array

    def predict(self, times: Array | Sequence[float], walls: object = None) -> Prediction:
        """The known motion, whatever the walls: one row for each mover, with weight 1 and without a margin."""
        times, count = np.array(times, float), len(self)
        known = Prediction(
            times=self.times,
            positions=self.positions,
            radius=self.radius,
            margin=np.zeros((count, len(self.times))),
            weight=np.ones(count),
            owner=self.ids,
            hypothesis=np.zeros(count, np.int64),
        )
        positions, margin = known.at(times)
        return replace(known, times=times, positions=positions.transpose(1, 0, 2), margin=margin.T)


class Foresight:
    """Gives oracles the true movers of each period: copies of the scripts go on in a copy of the world.

    They do what the scripts would do if all robots went on at their present speeds and turn rates, and stopped nothing
    that touches them. Movers are the round bodies that scripts move: people, but no doors.
    """

    def __init__(self, world: MujocoWorld, scripts: Sequence[ScriptedObject], oracles: Sequence[WorldModel]) -> None:
        self._world, self._oracles, self._ghost = world, oracles, GhostWorld(world)
        radii = [(s, self._ghost.radius(s.name)) for s in scripts if s.name not in world.parts]
        self._radii = {script: radius for script, radius in radii if radius is not None}
        self._looked = -math.inf
        self._times: Array = np.zeros(1)
        self._positions: Array = np.zeros((len(self._radii), 1, 2))

    def step(self, t: float) -> None:
        """Replace the movers of the oracles, at the beginning of a control period."""
        if t - self._looked > EVERY - 1e-6 and self._radii:
            self._look(t)
        world, names = self._world, [script.name for script in self._radii]
        mean = np.array([[*world.object_pose(name)[:2], *world.velocity(name)] for name in names]).reshape(-1, 4)
        known = Movers.of(t, mean, np.array(list(self._radii.values())))
        own = {field.name: getattr(known, field.name) for field in fields(known)}
        for oracle in self._oracles:
            oracle.movers = oracle.foreseen = Foreseen(**own, times=self._times, positions=self._positions)

    def _look(self, t: float) -> None:
        ghost = self._ghost
        ghost.mirror()
        # The memo puts the ghost in the place of the world: the copies draw the random numbers that their originals
        # will draw, but move objects of the ghost.
        scripts = [copy.deepcopy(script, {id(self._world): ghost}) for script in self._radii]
        period, rows = scripts[0].control_period, list[list[Pose2]]()
        self._looked, self._times = t, np.array(t + period * np.arange(round(HORIZON / period) + 1), float)
        for then in self._times.tolist():
            rows.append([ghost.object_pose(script.name) for script in scripts])
            for script, pose in zip(scripts, rows[-1], strict=True):
                ghost.set_object_velocity(script.name, script.velocity(then, (pose.x, pose.y)))
            ghost.go_on(period)
        self._positions = np.array(rows, np.float64)[..., :2].transpose(1, 0, 2)
