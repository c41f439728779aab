"""Shrinking: reduce a scene in which a planner fails to a minimal one with the same outcome.

Delta debugging (Zeller and Hildebrandt, Simplifying and isolating failure-inducing input, IEEE TSE 28, 2002) over the
obstacles of a scene, then a shorter path, then rounder numbers, repeated until nothing changes.

Hypothesis is not used: it shrinks the random choices of the generator, and one box fewer changes all later choices, so
its result is unrelated to the original failure. It also stops by wall-clock time and tries one candidate at a time.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ...control.footprint import Footprint
from ..obstacle import Point
from ..record import EpisodeRecord
from .draft import CELL, Draft
from .player import Player

STEPS = ((1.0, 90.0), (0.5, 45.0), (0.1, 15.0), (0.05, 5.0), (0.01, 1.0))
"""Rounding steps, the coarsest first: [m, m/s, s] and [deg]."""

SHARES = (0.5, 0.75, 0.9)
"""Shares of the path that shortening keeps."""

_APART = 1.0  # [m] a mover that starts at least this far from the robot is fair
_NEAREST = 1.0  # [m] minimum distance from start to goal; a shorter task is not simpler


@dataclass(frozen=True)
class Fairness:
    """Properties that shrinking must preserve, so that success stays possible: clearance at both ends, and a path.

    Attributes:
        radius: Radius of a disc that has a path [m]; 0 if even the original scene has no path for the robot.
        start: Clearance around the robot's centre at the start [m].
        goal: Clearance around the goal [m].
        apart: Minimum distance from the start to the start of any mover [m].
        distance: Distance from start to goal [m].
    """

    radius: float
    start: float
    goal: float
    apart: float
    distance: float

    @staticmethod
    def of(draft: Draft, body: Footprint) -> Fairness:
        """Properties of the original scene, limited to what a robot needs."""
        radius = next(
            (r for r in (body.outer + CELL, body.outer, body.inner) if draft.shortest_path(r) is not None), 0.0
        )
        enough = body.outer + CELL
        start, goal = (min(_clearance(draft, point), enough) for point in (draft.start, draft.goal))
        return Fairness(radius, start, goal, min(_apart(draft), _APART), min(_distance(draft), _NEAREST))

    def holds(self, draft: Draft) -> bool:
        """Whether a draft has the properties."""
        start, goal = _clearance(draft, draft.start), _clearance(draft, draft.goal)
        if start < self.start or goal < self.goal:
            return False
        if _apart(draft) < self.apart or _distance(draft) < self.distance - 1e-6:
            return False
        return self.radius == 0.0 or draft.shortest_path(self.radius) is not None


class Shrinking:
    """Shrinks a draft while the planner fails in it with the same outcome.

    Args:
        player: Player of drafts.
        draft: Scene in which the planner failed.
        record: Its episode.
        body: Outline of the robot.
    """

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
        """Continue with the first draft that fails with the same outcome; returns whether there is one."""
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
        """Move start and goal towards each other along the path."""
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
        """Round numbers, of all objects at once or one after another."""
        names = ["", *self.draft.obstacles]
        for chosen in ([names] if len(names) > 1 else []) + [[name] for name in names]:
            self._first(d for step in STEPS for d in self._fairly(self.draft.rounded(*step, chosen)))

    def _fairly(self, draft: Draft) -> Iterator[Draft]:
        if draft != self.draft and self._fair.holds(draft):
            yield draft


def point_along(points: tuple[Point, ...], length: float) -> Point:
    """Point of a polyline at a path length [m]; its end if the polyline is shorter."""
    for a, b in pairwise(points):
        piece = math.dist(a, b)
        if length <= piece > 0.0:
            x, y = (np.array(a) + length / piece * (np.array(b) - a)).tolist()
            return x, y
        length -= piece
    return points[-1]


def _clearance(draft: Draft, point: Point) -> float:
    """Clearance at a point on the grid [m]."""
    grid = draft.ground.grid(CELL)
    return float(grid.clearances()[grid.cell_at(point)])


def _distance(draft: Draft) -> float:
    return math.dist(draft.start, draft.goal)


def _apart(draft: Draft) -> float:
    standing = {obstacle.name for obstacle in draft.ground.obstacles}
    return min((math.dist(p, draft.start) for n, p in draft.obstacles.items() if n not in standing), default=math.inf)
