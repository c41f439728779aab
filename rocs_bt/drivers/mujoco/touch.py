"""Noticing contacts as they begin."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .body import FLOOR, RobotBody, geom_labels

_APART = 0.2  # [s] for which two things must be apart before their next contact is a new one
_STILL = 0.02  # [m/s] below which a robot stands still
_STILL_TURN = 0.05  # [rad/s]


@dataclass(frozen=True)
class Contact:
    """A contact that began.

    Attributes:
        t: When [s].
        robot: Whose.
        other: What it touched.
        moving: Whether the robot moved, or was commanded to, as it began.
    """

    t: float
    robot: str
    other: str
    moving: bool


class ContactDetector:
    """Looks at MuJoCo's contacts after each physics step, and tells which ones are new.

    Args:
        model: The compiled model.
        robots: What belongs to which robot.

    Attributes:
        usual: How many contacts there are when all is well: wheels and casters on the floor. While there are as
            many there is nothing to look for, but for a wheel that lifts just as something is touched: look now and
            then all the same.
    """

    def __init__(self, model: Any, robots: Mapping[str, RobotBody]) -> None:
        self._robots = robots
        self._names = geom_labels(model, robots)
        self._floor = {geom for geom, name in enumerate(self._names) if name == FLOOR}
        self.usual = -1
        self._before = np.zeros(model.nv)
        self._touching: dict[tuple[str, str], float] = {}
        self._new: list[Contact] = []

    def begin(self, data: Any) -> None:
        """Remember how everything moves before the next steps: an impact changes it."""
        self._before[:] = data.qvel

    def update(self, data: Any, t: float, commanded: Callable[[str], bool]) -> None:
        """Look for contacts after a step.

        Args:
            data: MuJoCo's.
            t: The time after the step [s].
            commanded: Tells whether a robot is asked to move.
        """
        plain = True
        names, floor = self._names, self._floor
        for one, two in data.contact.geom.tolist():
            if one in floor or two in floor:
                continue
            a, b = names[one], names[two]
            if a == b:
                continue
            for robot, other in ((a, b), (b, a)):
                if robot in self._robots:
                    plain = False
                    self._touch(robot, other, t, commanded)
        if plain:
            self.usual = data.ncon

    def drain(self) -> list[Contact]:
        """The contacts that began since the last call."""
        new, self._new = self._new, []
        return new

    def _touch(self, robot: str, other: str, t: float, commanded: Callable[[str], bool]) -> None:
        last = self._touching.get((robot, other))
        self._touching[(robot, other)] = t
        if last is None or t - last > _APART:
            self._new.append(Contact(t, robot, other, commanded(robot) or self._moves(robot)))

    def _moves(self, robot: str) -> bool:
        v = self._robots[robot].v
        x, y, _, _, _, turn = self._before[v : v + 6].tolist()
        return bool(x * x + y * y > _STILL**2 or abs(turn) > _STILL_TURN)
