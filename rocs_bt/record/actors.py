"""Movements of scripted actors: when they begin and end, and whether a door is open or shut."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Sequence

from ..event import BodyMoved, Event
from .header import BodyInfo, Outline, Point

WINDOW = 1.0
"""Time within which an actor at rest moves by `STEP` if it begins to move [s]."""

REST = 0.5
"""Time within which an actor does not move if it is at rest [s]."""

STEP, STILL = 0.01, 0.002
"""Distances that count as a movement, and as none [m], of the point of the outline that moves most."""

_LONG = 3.0  # length of a door in its widths
_NEAR = 0.15  # distance of a door from the wall beside it [m]
_Pose = tuple[float, float, float, float]  # t, x, y, yaw


class ActorMoved(Event, frozen=True, kw_only=True):
    """A scripted actor began to move, stopped, or appeared. It is derived from its poses and not recorded.

    Attributes:
        body: Name of the actor.
        state: `moves`, `appears`, or the state at rest: `open` or `shut` for a door, else `at rest`.
        since: Time at which the state began [s]; a little before the event.
    """

    body: str
    state: str
    since: float

    @property
    def sentence(self) -> str:
        """The event for people; none for the state at the start of a run."""
        if self.state in ("moves", "appears"):
            return f"{self.body} {'begins to move' if self.state == 'moves' else self.state}"
        return "" if self.t == self.since else f"{self.body} is {self.state} since {self.since:.2f} s"


class ActorMotion:
    """Movements of one actor; fed with its poses.

    Args:
        body: The actor.
        walls: Outlines of what never moves.
        start: Time at which the run began [s].
    """

    def __init__(self, body: BodyInfo, walls: Sequence[Outline], start: float) -> None:
        self._body, self._walls, self._start = body, walls, start
        self._arm = max((math.hypot(*point) for point in body.hull), default=0.1)
        self._poses: deque[_Pose] = deque()
        self._moves = False

    def take(self, event: BodyMoved) -> ActorMoved | None:
        """Take a pose; returns what has just begun or ended, of the first pose the state at rest."""
        poses, now = self._poses, (event.t, event.x, event.y, event.yaw)
        first, keep = not poses, REST if self._moves else WINDOW
        poses.append(now)
        while len(poses) > 1 and poses[1][0] <= event.t - keep + 1e-6:
            poses.popleft()
        if first:
            late = event.t > self._start + WINDOW
            return self._changed(event.t, "appears" if late else self._rest(now), event.t)
        if not self._moves and self._apart(poses[0], now) > STEP:
            began = next(poses[i - 1][0] for i in range(1, len(poses)) if self._apart(poses[0], poses[i]) > STILL)
            self._moves = True
            return self._changed(event.t, "moves", began)
        rests = poses[0][0] <= event.t - REST + 1e-6 and all(self._apart(pose, now) <= STILL for pose in poses)
        if self._moves and rests:
            self._moves = False
            return self._changed(event.t, self._rest(now), poses[0][0])
        return None

    def _apart(self, one: _Pose, other: _Pose) -> float:
        turn = math.remainder(one[3] - other[3], math.tau)
        return max(math.hypot(one[1] - other[1], one[2] - other[2]), self._arm * abs(turn))

    def _changed(self, t: float, state: str, since: float) -> ActorMoved:
        return ActorMoved(t=t, agent="", body=self._body.name, state=state, since=since)

    def _rest(self, pose: _Pose) -> str:
        return door_state(self._body.hull, pose[1:], self._walls) or "at rest"


def door_state(hull: Sequence[Point], pose: tuple[float, float, float], walls: Iterable[Outline]) -> str:
    """Whether a door is `open` or `shut`; empty for what is no door.

    A door is long and thin. It is shut if both ends are at a wall and its middle is not, and open if a wall is along
    it or at one end only.

    Args:
        hull: Outline from above [m], body frame.
        pose: Position [m] and heading [rad], world frame.
        walls: Outlines of what never moves.
    """
    axis = _axis(hull)
    if axis is None:
        return ""
    x, y, yaw = pose
    c, s = math.cos(yaw), math.sin(yaw)
    points = [(x + c * u - s * v, y + s * u + c * v) for u, v in axis]
    known = list(walls)
    one, quarter, middle, other_quarter, other = (any(_distance(p, wall) < _NEAR for wall in known) for p in points)
    if quarter and middle and other_quarter:
        return "open"
    if one and other:
        return "" if middle else "shut"
    return "open" if one or other else ""


def _axis(hull: Sequence[Point]) -> list[Point] | None:
    """Ends, quarters and middle of a long outline along its greatest length; None if it is not long."""
    pairs = [(a, b) for i, a in enumerate(hull) for b in hull[i + 1 :]]
    if not pairs:
        return None
    (ax, ay), (bx, by) = max(pairs, key=lambda pair: math.dist(*pair))
    length = math.dist((ax, ay), (bx, by))
    mx, my = sum(x for x, _ in hull) / len(hull), sum(y for _, y in hull) / len(hull)
    # The diagonal of a thin outline is nearly its axis: the width is the distance of the corners across it.
    across = [((x - mx) * (by - ay) - (y - my) * (bx - ax)) / length for x, y in hull] if length else [0.0]
    if length < _LONG * (max(across) - min(across)):
        return None
    ux, uy = (bx - ax) / 2.0, (by - ay) / 2.0
    return [(mx + part * ux, my + part * uy) for part in (-1.0, -0.5, 0.0, 0.5, 1.0)]


def _distance(point: Point, outline: Outline) -> float:
    """Distance of a point from an outline [m]; 0 inside."""
    x, y = point
    if outline.radius > 0.0:
        return max(0.0, math.dist(point, outline.points[0]) - outline.radius)
    inside, least = False, math.inf
    for (ax, ay), (bx, by) in zip(outline.points, (*outline.points[1:], outline.points[0]), strict=True):
        if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
            inside = not inside
        dx, dy = bx - ax, by - ay
        part = min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy or 1.0)))
        least = min(least, math.hypot(x - ax - part * dx, y - ay - part * dy))
    return 0.0 if inside else least
