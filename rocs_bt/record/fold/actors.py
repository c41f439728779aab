"""Movements of actors: when they begin and end, and whether a door is open or shut."""

from __future__ import annotations

import math
from collections import deque

from ...event import BodyMoved, Event
from ..file.header import BodyInfo

WINDOW = 1.0
"""Time within which an actor at rest moves by `STEP` if it begins to move [s]."""

REST = 0.5
"""Time within which an actor does not move if it is at rest [s]."""

STEP, STILL = 0.01, 0.002
"""Distances that count as a movement, and as none [m], of the point of the outline that moves most."""

_NEAR = 0.05  # distance from a pose of the script at which an actor is there [m]
_Pose = tuple[float, float, float, float]  # t, x, y, yaw


class ActorMoved(Event, frozen=True, kw_only=True):
    """A scripted actor began to move, stopped, or appeared. It is derived from its poses and not recorded.

    Attributes:
        body: Name of the actor.
        state: `moves`, `appears`, or the state at rest: `open` or `shut` for a door, else `at rest`.
        since: Time at which the state began [s]; a little before the event.
        scripted: Whether a script moves the actor.
    """

    body: str
    state: str
    since: float
    scripted: bool = False

    @property
    def sentence(self) -> str:
        """The event for people; none for the state at the start of a run."""
        if self.state in ("moves", "appears"):
            begins = "begins to move" if self.state == "moves" else self.state
            return f"{self.body} {begins}{' (scripted)' if self.scripted else ''}"
        return "" if self.t == self.since else f"{self.body} is {self.state} since {self.since:.2f} s"


class ActorMotion:
    """Movements of one actor; fed with its poses.

    Args:
        body: The actor.
        start: Time at which the run began [s].
    """

    def __init__(self, body: BodyInfo, start: float) -> None:
        self._body, self._start = body, start
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
        scripted = bool(self._body.script)
        return ActorMoved(t=t, agent="", body=self._body.name, state=state, since=since, scripted=scripted)

    def _rest(self, pose: _Pose) -> str:
        near = (state for state, there in self._body.states.items() if self._apart(pose, (0.0, *there)) < _NEAR)
        return next(near, "at rest")
