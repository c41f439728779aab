"""Shrinking: simplify a scene in which a planner fails, as far as the planner still fails in the same way.

Obstacles are removed by delta debugging (Zeller and Hildebrandt, Simplifying and isolating failure-inducing input, IEEE
TSE 28, 2002). Then the path is shortened and numbers are rounded. All this is repeated until nothing changes.

The library Hypothesis is not used. It would shrink the random choices of the generator; one box fewer changes all later
choices, so the result would be unrelated to the original failure. It also stops by wall-clock time and tries only one
candidate at a time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..compare.obstacle import Point
from ..compare.record import EpisodeRecord
from ..control.footprint import Footprint
from .draft import CELL, Draft
from .player import Player

STEPS = ((1.0, 90.0), (0.5, 45.0), (0.1, 15.0), (0.05, 5.0), (0.01, 1.0))
"""Rounding steps, the coarsest first: [m, m/s, s] and [deg]."""

SHARES = (0.5, 0.75, 0.9)
"""Shares of the path from start to goal that remain when the path is shortened, in the order tried."""

_APART = 1.0  # [m] distance from the robot at which an actor may start in any simplified scene
_NEAREST = 1.0  # [m] distance from start to goal to which any simplified scene may be shortened


@dataclass(frozen=True)
class Fairness:
    """Lower limits that every simplified scene must keep, so that success stays possible in it.

    Attributes:
        radius: Radius of a disc for which there is a path [m]; 0 if even the original scene has no path for the robot.
        start: Minimum clearance around the robot's centre at the start [m].
        goal: Minimum clearance around the goal [m].
        apart: Minimum distance from the robot's start to the start of any actor [m].
        distance: Minimum distance from start to goal [m].
    """

    radius: float
    start: float
    goal: float
    apart: float
    distance: float

    @staticmethod
    def of(draft: Draft, body: Footprint) -> Fairness:
        """Limits for simplifying a scene: the values of this scene, but no more than a robot needs."""
        radius = next(
            (r for r in (body.outer + CELL, body.outer, body.inner) if draft.shortest_path(r) is not None), 0.0
        )
        enough = body.outer + CELL
        start, goal = (min(_clearance(draft, point), enough) for point in (draft.start, draft.goal))
        return Fairness(radius, start, goal, min(_apart(draft), _APART), min(_distance(draft), _NEAREST))

    def holds(self, draft: Draft) -> bool:
        """Whether a draft keeps all limits."""
        start, goal = _clearance(draft, draft.start), _clearance(draft, draft.goal)
        if start < self.start or goal < self.goal:
            return False
        if _apart(draft) < self.apart or _distance(draft) < self.distance - 1e-6:
            return False
        return self.radius == 0.0 or draft.shortest_path(self.radius) is not None


class Shrinking:
    """Simplifies a draft step by step; a step is kept if the planner still fails with the same outcome."""

    def __init__(self, player: Player, draft: Draft, record: EpisodeRecord, body: Footprint) -> None:
        self.draft, self.record = draft, record
        self._player = player
        self._fair = Fairness.of(draft, body)

    def run(self) -> None:
        """Shrink until nothing changes or the budget is spent."""
        before = None
        while before != self.draft and self._player.count < self._player.budget:
            before = self.draft
            self._drop_obstacles()
            self._shorten()
            self._round()

    def _first(self, drafts: Iterator[Draft]) -> bool:
        """Continue with the first draft in which the planner fails with the same outcome; False if there is none."""
        outcome = self.record.outcome
        found = self._player.first((d for d in drafts if d != self.draft), lambda r: r.outcome == outcome)
        if found is not None:
            self.draft, self.record = found
        return found is not None

    def _drop_obstacles(self) -> None:
        """Remove obstacles in chunks of decreasing size, those farthest from the end of the failed episode first."""
        end = self.record.path[-1].tolist() if len(self.record.path) else self.draft.start
        names = sorted(self.draft.obstacles, key=lambda n: (-math.dist(self.draft.obstacles[n], end), n))
        size = len(names)
        while size:
            needed: list[str] = []  # names of which no chunk of this size can be removed
            while names:
                chunks = [names[i : i + size] for i in range(0, len(names), size)]
                if not self._first(self.draft.without(chunk) for chunk in chunks):
                    break
                removed = next(i for i, chunk in enumerate(chunks) if chunk[0] not in self.draft.obstacles)
                needed += names[: removed * size]
                names = names[(removed + 1) * size :]
            names = needed + names
            size //= 2

    def _shorten(self) -> None:
        """Move start or goal along the path between them, as long as the planner still fails."""
        while self.draft.movable and self._fair.radius and self._first(self._shorter()):
            pass

    def _shorter(self) -> Iterator[Draft]:
        if (path := self.draft.shortest_path(self._fair.radius)) is None:
            return
        for share in SHARES:
            for start, goal in ((0.0, share), (1.0 - share, 1.0)):
                points = (point_along(path.points, at * path.length) for at in (start, goal))
                yield from self._fairly(self.draft.between(*points))

    def _round(self) -> None:
        """Round the numbers of all objects at once, then those of each object."""
        names = ["", *self.draft.obstacles]
        for chosen in ([names] if len(names) > 1 else []) + [[name] for name in names]:
            self._first(d for step in STEPS for d in self._fairly(self.draft.rounded(*step, chosen)))

    def _fairly(self, draft: Draft) -> Iterator[Draft]:
        if draft != self.draft and self._fair.holds(draft):
            yield draft


def point_along(points: tuple[Point, ...], length: float) -> Point:
    """Point of a polyline at a distance [m] along it; the end point if the polyline is shorter."""
    for a, b in pairwise(points):
        piece = math.dist(a, b)
        if length <= piece > 0.0:
            x, y = (np.array(a) + length / piece * (np.array(b) - a)).tolist()
            return x, y
        length -= piece
    return points[-1]


def _clearance(draft: Draft, point: Point) -> float:
    """Distance from a point to the nearest static obstacle, measured on a grid [m]."""
    grid = draft.floor.grid(CELL)
    return float(grid.clearances()[grid.cell_at(point)])


def _distance(draft: Draft) -> float:
    return math.dist(draft.start, draft.goal)


def _apart(draft: Draft) -> float:
    standing = {obstacle.name for obstacle in draft.floor.obstacles}
    return min((math.dist(p, draft.start) for n, p in draft.obstacles.items() if n not in standing), default=math.inf)
