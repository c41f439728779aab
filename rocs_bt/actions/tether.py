"""Tether: where a robot that is tied to its leader goes, and where it makes room."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..control.drive import Array
from ..geometry import Pose2

SPACING = 0.05  # [m] between the places of a trail
TRAIL = 2.0  # [m] that it remembers: farther back nobody needs to go, and things may have moved

_LOOK = 0.3  # [m] ahead of each step, where nobody must be
_DETOURS = [math.radians(sign * angle) for angle in (0.0, 20.0, 40.0, 60.0, 80.0) for sign in (1.0, -1.0)][1:]
_TURNS = [math.radians(turn) for turn in (0.0, 20.0, -20.0, 40.0, -40.0)]
_AHEAD = 0.8  # [m] of room in front without which nobody is evaded that way
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
        here, back, rows = pose, self._back(pose), [pose]
        stride = self.speed * step
        for i, place in enumerate(leader[1:], 1):
            others = [peer[i] for peer in peers]
            away = here.distance(place)
            moved = here
            if away > self.length:
                moved = self._pulled(here, place, min(away - self.length, stride), others)
            elif away < self.room:
                moved = self._pushed(here, place, back, stride, others)
            near = min(others, key=here.distance, default=None)
            if moved is here and near is not None and here.distance(near) < self.keep_off + _MARGIN:
                moved = self._pushed(here, near, back, stride, [*others, place])
                moved = self._evaded(here, place, near, others, stride, ahead) if moved is here else moved
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

    def _pushed(
        self, here: Pose2, place: Pose2, back: Iterator[Pose2], stride: float, others: Sequence[Pose2]
    ) -> Pose2:
        """The next place on the way back, while that leads away from the leader."""
        gone = 0.0
        while gone < stride:
            there = next(back, None)
            if there is None or there.distance(place) <= here.distance(place) or not self.free(here, there, others):
                return here
            gone += here.distance(there)
            here = there
        return here

    def _back(self, pose: Pose2) -> Iterator[Pose2]:
        """The trail from its end to its beginning, in places close enough for any stride."""
        for place in reversed(self._trail):
            away = pose.distance(place)
            for share in np.linspace(0.0, 1.0, max(2, math.ceil(away / 0.01)))[1:].tolist():
                yaw = pose.yaw + share * math.remainder(place.yaw - pose.yaw, math.tau)
                yield Pose2(pose.x + share * (place.x - pose.x), pose.y + share * (place.y - pose.y), yaw)
            pose = place

    def free(self, here: Pose2, there: Pose2, others: Sequence[Pose2]) -> bool:
        """Whether a step comes too near to nobody, or at least no nearer."""
        return all((d := there.distance(o)) >= self.keep_off or d >= here.distance(o) for o in others)
