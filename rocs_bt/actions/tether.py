"""Tether: where a robot that is tied to its leader goes, and where it makes room."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice

import numpy as np

from ..control.drive import Array
from ..geometry import Pose2

SPACING = 0.05  # [m] between the places of a trail
TRAIL = 2.0  # [m] that it remembers: farther back nobody needs to go, and things may have moved

_FINE = 0.01  # [m] between places on the way back
_LOOK = 0.3  # [m] ahead of each step, where nobody must be
_DETOURS = [math.radians(sign * angle) for angle in (0.0, 20.0, 40.0, 60.0, 80.0) for sign in (1.0, -1.0)][1:]
_TURNS = [math.radians(turn) for turn in (0.0, 20.0, -20.0, 40.0, -40.0)]
_AHEAD = 0.8  # [m] of room in front without which nobody is evaded that way
_PATIENCE = 0.3  # [m] by which the string may be too long while it makes room for somebody
_MARGIN = 0.15  # [m] more than `keep_off`, within which it gives way


@dataclass
class Tether:
    """A string between two robots, with a stop in it: it pulls when it is taut, and pushes when it is too short.

    Pulled, the robot goes straight at its leader, as a trailer does, and round whoever is in the way. Pushed, it
    goes back on its own trail: where it
    has just been nothing stands, and it may have no eyes behind.

    Args:
        length: At which the string is taut [m].
        room: At which it pushes [m].
        keep_off: How near the robot goes to anybody else [m].
        speed: How fast it can be moved [m/s].
    """

    length: float
    room: float
    keep_off: float
    speed: float
    _trail: list[Pose2] = field(default_factory=list, init=False)

    def moved(self, pose: Pose2) -> None:
        """The robot is here now; remembers where it has been, and forgets what it has gone back on."""
        trail = self._trail
        while len(trail) > 1 and pose.distance(trail[-2]) < trail[-1].distance(trail[-2]):
            trail.pop()
        if not trail or pose.distance(trail[-1]) >= SPACING:
            trail.append(pose)
        if len(trail) * SPACING > TRAIL:
            trail.pop(0)

    def way(
        self,
        pose: Pose2,
        leader: Sequence[Pose2],
        peers: Sequence[Sequence[Pose2]],
        step: float,
        ahead: float = math.inf,
    ) -> Array:
        """(k, 3) Where the string takes the robot while its leader passes (k) poses.

        Args:
            pose: Where it is.
            leader: The leader's predicted poses, the first of them now.
            peers: Who else to keep off, each with as many predicted poses.
            step: Time between two of the poses [s].
            ahead: How much room it sees in front [m].
        """
        here, back, rows = pose, _Back(pose, self._trail), [pose]
        stride = self.speed * step
        for i, place in enumerate(leader[1:], 1):
            others = [peer[i] for peer in peers]
            away = here.distance(place)
            near = min(others, key=here.distance, default=None)
            threat = near if near is not None and here.distance(near) < self.keep_off + _MARGIN else None
            moved = here
            if away > self.length + (_PATIENCE if threat else 0.0):
                moved = self._pulled(here, place, min(away - self.length, stride), others)
            elif away < self.room:
                moved = self._pushed(here, place, back, stride, others)
            if moved is here and threat is not None:
                moved = self._pushed(here, threat, back, stride, [*others, place])
                moved = self._evaded(here, place, threat, others, stride, ahead) if moved is here else moved
            here = moved
            rows.append(here)
        return np.array(rows)

    def _pulled(self, here: Pose2, place: Pose2, pull: float, others: Sequence[Pose2]) -> Pose2:
        """The next place on the way to the leader, straight or round who is in the way; here where there is none."""
        angle = math.atan2(place.y - here.y, place.x - here.x)
        for detour in _DETOURS:
            c, s = math.cos(angle + detour), math.sin(angle + detour)
            if self.free(here, Pose2(here.x + _LOOK * c, here.y + _LOOK * s), others):
                return Pose2(here.x + pull * c, here.y + pull * s, angle + detour)
        return here

    def _evaded(
        self, here: Pose2, place: Pose2, near: Pose2, others: Sequence[Pose2], stride: float, ahead: float
    ) -> Pose2:
        """The next place ahead that leads away from who is near and keeps to the leader; here where none does."""
        reach = max(self.length, here.distance(place))

        def gain(heading: float) -> float:
            there = Pose2(here.x + _LOOK * math.cos(heading), here.y + _LOOK * math.sin(heading))
            if ahead < _AHEAD or not self.free(here, there, others) or there.distance(place) < self.room:
                return -math.inf
            return there.distance(near) - here.distance(near) - max(0.0, there.distance(place) - reach)

        best = max((here.yaw + turn for turn in _TURNS), key=gain)
        if gain(best) < 0.3 * _LOOK:
            return here
        return Pose2(here.x + stride * math.cos(best), here.y + stride * math.sin(best), best)

    def _pushed(self, here: Pose2, place: Pose2, back: _Back, stride: float, others: Sequence[Pose2]) -> Pose2:
        """The next place on the way back, taken from it, if that way leads away from a place."""
        count = max(1, round(stride / _FINE))
        there, beyond = back.at(count), back.at(count + round(_LOOK / _FINE))
        if there is None or beyond is None:
            return here
        if beyond.distance(place) <= here.distance(place) or not self.free(here, beyond, others):
            return here
        back.take(count)
        return there

    def free(self, here: Pose2, there: Pose2, others: Sequence[Pose2]) -> bool:
        """Whether a step comes too near to nobody, or at least no nearer."""
        return all((d := there.distance(o)) >= self.keep_off or d >= here.distance(o) for o in others)


class _Back:
    """A trail from where the robot is to its beginning, in fine places; made as far as it is asked for.

    Args:
        pose: Where the robot is.
        trail: Where it has been, oldest first.
    """

    def __init__(self, pose: Pose2, trail: Sequence[Pose2]) -> None:
        self._beyond = _fine(pose, trail)
        self._places: list[Pose2] = []
        self._taken = 0

    def at(self, ahead: int) -> Pose2 | None:
        """The place so many fine steps on, the last one beyond the end; None when all are taken."""
        missing = self._taken + ahead - len(self._places)
        self._places += islice(self._beyond, max(0, missing))
        left = len(self._places) - self._taken
        return self._places[self._taken + min(ahead, left) - 1] if left else None

    def take(self, count: int) -> None:
        """Go on by so many fine steps, of those that `at` has shown."""
        self._taken = min(self._taken + count, len(self._places))


def _fine(pose: Pose2, trail: Sequence[Pose2]) -> Iterator[Pose2]:
    """A trail from its end, where the robot is, to its beginning, in fine places."""
    for place in reversed(trail):
        for share in np.linspace(0.0, 1.0, 1 + math.ceil(pose.distance(place) / _FINE))[1:].tolist():
            yaw = pose.yaw + share * math.remainder(place.yaw - pose.yaw, math.tau)
            yield Pose2(pose.x + share * (place.x - pose.x), pose.y + share * (place.y - pose.y), yaw)
        pose = place
