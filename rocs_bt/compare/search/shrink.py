"""Shrinking: from a scene in which a planner fails to the smallest in which it still fails in the same manner.

Delta debugging (Zeller and Hildebrandt, Simplifying and isolating failure-inducing input, IEEE TSE 28, 2002) over the
things of a scene, then a shorter way, then simpler numbers, again and again until nothing more can be left out.

Hypothesis shrinks the numbers that a scene was drawn from; but one box fewer draws all others anew, and what is found
so has nothing to do with what failed. It also ends by the clock on the wall, and tries one candidate at a time.
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
"""What numbers are rounded to, the simplest first: [m, m/s, s] and [deg]."""

SHARES = (0.5, 0.75, 0.9)
"""Of its way, that are left."""

_APART = 1.0  # [m] between the start and a mover's that nobody could call unfair
_NEAREST = 1.0  # [m] between start and goal; less is no simpler, and ends where nothing is to be done


@dataclass(frozen=True)
class Fairness:
    """What a scene must keep, so that who fails in it could have done better: room at both ends, and a way.

    Attributes:
        radius: Of a disc that has a way [m]; 0 where the scene as it was found has none for the robot either.
        start: The room around the middle of the robot where it starts [m].
        goal: The room around the goal [m].
        apart: How far movers begin from the start [m].
        distance: From start to goal [m].
    """

    radius: float
    start: float
    goal: float
    apart: float
    distance: float

    @staticmethod
    def of(draft: Draft, body: Footprint) -> Fairness:
        """What a scene as it was found has, as far as a robot needs it."""
        radius = next(
            (r for r in (body.outer + CELL, body.outer, body.inner) if draft.shortest_path(r) is not None), 0.0
        )
        enough = body.outer + CELL
        start, goal = (min(_clearance(draft, point), enough) for point in (draft.start, draft.goal))
        return Fairness(radius, start, goal, min(_apart(draft), _APART), min(_distance(draft), _NEAREST))

    def holds(self, draft: Draft) -> bool:
        """Whether a scene has it."""
        start, goal = _clearance(draft, draft.start), _clearance(draft, draft.goal)
        if start < self.start or goal < self.goal:
            return False
        if _apart(draft) < self.apart or _distance(draft) < self.distance - 1e-6:
            return False
        return self.radius == 0.0 or draft.shortest_path(self.radius) is not None


class Shrinking:
    """Makes a draft smaller, as long as the planner fails in it in the same manner.

    Args:
        player: Who plays.
        draft: The scene in which it failed.
        record: Its episode.
        body: The robot's outline.
    """

    def __init__(self, player: Player, draft: Draft, record: EpisodeRecord, body: Footprint) -> None:
        self.draft, self.record = draft, record
        self._player = player
        self._fair = Fairness.of(draft, body)

    def run(self) -> None:
        """Shrink until nothing more can be left out, or the budget is spent."""
        before = None
        while before != self.draft and self._player.count < self._player.budget:
            before = self.draft
            self._drop_obstacles()
            self._shorten()
            self._round()

    def _first(self, drafts: Iterator[Draft]) -> bool:
        """Go on with the first draft that fails as this one does; whether there is one."""
        outcome = self.record.outcome
        found = self._player.first((d for d in drafts if d != self.draft), lambda r: r.outcome == outcome)
        if found is not None:
            self.draft, self.record = found
        return found is not None

    def _drop_obstacles(self) -> None:
        """Leave things out, many at a time first, those that are far from where it failed before others."""
        end = self.record.path[-1].tolist() if len(self.record.path) else self.draft.start
        names = sorted(self.draft.obstacles, key=lambda n: (-math.dist(self.draft.obstacles[n], end), n))
        size = len(names)
        while size:
            needed: list[str] = []  # of this size no chunk of these can be left out
            while names:
                chunks = [names[i : i + size] for i in range(0, len(names), size)]
                if not self._first(self.draft.without(chunk) for chunk in chunks):
                    break
                gone = next(i for i, chunk in enumerate(chunks) if chunk[0] not in self.draft.obstacles)
                needed += names[: gone * size]
                names = names[(gone + 1) * size :]
            names = needed + names
            size //= 2

    def _shorten(self) -> None:
        """Bring start and goal nearer to each other, along the way between them."""
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
        """Write simpler numbers, all at once or one thing after the other."""
        names = ["", *self.draft.obstacles]
        for chosen in ([names] if len(names) > 1 else []) + [[name] for name in names]:
            self._first(d for step in STEPS for d in self._fairly(self.draft.rounded(*step, chosen)))

    def _fairly(self, draft: Draft) -> Iterator[Draft]:
        if draft != self.draft and self._fair.holds(draft):
            yield draft


def point_along(points: tuple[Point, ...], length: float) -> Point:
    """The point of a polygon that is so far along it [m]; its end beyond."""
    for a, b in pairwise(points):
        piece = math.dist(a, b)
        if length <= piece > 0.0:
            x, y = (np.array(a) + length / piece * (np.array(b) - a)).tolist()
            return x, y
        length -= piece
    return points[-1]


def _clearance(draft: Draft, point: Point) -> float:
    """The room around a place, as far as the grid tells [m]."""
    grid = draft.ground.grid(CELL)
    return float(grid.clearances()[grid.cell_at(point)])


def _distance(draft: Draft) -> float:
    return math.dist(draft.start, draft.goal)


def _apart(draft: Draft) -> float:
    standing = {obstacle.name for obstacle in draft.ground.obstacles}
    return min((math.dist(p, draft.start) for n, p in draft.obstacles.items() if n not in standing), default=math.inf)
