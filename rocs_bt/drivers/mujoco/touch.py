"""Detection of new contacts of robots."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from .body import FLOOR, GROUND, RobotBody, geom_labels

_APART = 0.2  # [s] minimum time of separation after which a contact of the same pair counts as new
_STILL = 0.02  # [m/s] maximum speed of a stationary robot
_STILL_TURN = 0.05  # [rad/s] maximum turn rate of a stationary robot
_STEEP = 0.5  # [1] maximum vertical component of the normal of a side face of the ground (steeper than 60 deg)


@dataclass(frozen=True)
class Contact:
    """New contact of a robot.

    Attributes:
        t: Time at which the contact began [s].
        robot: Name of the robot.
        other: Name of the touched obstacle or robot.
        moving: Whether the robot moved or was commanded to move when the contact began.
    """

    t: float
    robot: str
    other: str
    moving: bool


class ContactDetector:
    """Detector of new contacts of robots, used after physics steps.

    Contacts with the floor do not count, except those of a hull with a side face of ground that a scenario adds.

    Args:
        model: Compiled model.
        robots: Indices of the robots in the model, by name.

    Attributes:
        grounded: Geoms that touch the ground in the present state and should not, by robot; the first of each robot.
        spatial: Names of the robots for which vertical speed, roll rate and pitch rate count as motion, too.
        usual: Number of contacts in normal driving, which are those of wheels and casters with the floor. While MuJoCo
            reports this number, most updates can be skipped; not all, because a wheel may lift when the robot touches
            something.
    """

    def __init__(self, model: Any, robots: Mapping[str, RobotBody]) -> None:
        self._robots = robots
        self._names = geom_labels(model, robots)
        self._hulls = {geom for body in robots.values() for geom in body.hull}
        names = {geom: str(model.geom(geom).name) for geom in range(model.ngeom)}
        self._ground = {g: name.removeprefix(GROUND) for g, name in names.items() if name.startswith(GROUND)}
        self._floor = {geom for geom, name in enumerate(self._names) if name == FLOOR}
        self._off_ground: dict[int, tuple[str, int]] = {}  # robots and IDs of geoms that should not touch the ground
        self.grounded: dict[str, int] = {}
        self.spatial: set[str] = set()
        self.usual = -1
        self._before = np.zeros(model.nv)
        self._touching: dict[tuple[str, str], float] = {}
        self._new: list[Contact] = []

    def begin(self, data: Any) -> None:
        """Store all velocities before the next steps, because an impact changes them."""
        self._before[:] = data.qvel

    def update(self, data: Any, t: float, commanded: Callable[[str], bool]) -> None:
        """Detect new contacts after a step.

        Args:
            data: MjData of the world.
            t: Time after the step [s].
            commanded: Function from a robot's name to whether the robot is commanded to move.
        """
        plain = True
        names, floor, off_ground = self._names, self._floor, self._off_ground
        self.grounded = {}
        for i, (one, two) in enumerate(data.contact.geom.tolist()):
            if one in floor or two in floor:
                if one in off_ground or two in off_ground:
                    robot, geom = off_ground.get(one) or off_ground[two]
                    other = two if geom == one else one
                    ground = self._ground.get(other) if geom in self._hulls else None
                    if ground is not None and abs(data.contact.frame[i, 2]) < _STEEP:
                        plain = False
                        self._touch(robot, ground, t, commanded)
                    else:
                        self.grounded.setdefault(robot, geom)
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

    def allow_ground(self, robot: str, geoms: Collection[int]) -> None:
        """Set the geoms of a robot that may touch the ground.

        Args:
            robot: Name of the robot.
            geoms: IDs of the geoms.
        """
        for geom in self._robots[robot].geoms:
            self._off_ground.pop(geom, None)
            if geom not in geoms:
                self._off_ground[geom] = robot, geom

    def drain(self) -> list[Contact]:
        """Contacts that began since the last call."""
        new, self._new = self._new, []
        return new

    def _touch(self, robot: str, other: str, t: float, commanded: Callable[[str], bool]) -> None:
        last = self._touching.get((robot, other))
        self._touching[(robot, other)] = t
        if last is None or t - last > _APART:
            self._new.append(Contact(t, robot, other, commanded(robot) or self._moves(robot)))

    def _moves(self, robot: str) -> bool:
        v = self._robots[robot].v
        x, y, z, roll, pitch, turn = self._before[v : v + 6].tolist()
        if robot not in self.spatial:
            z = roll = pitch = 0.0
        return bool(x * x + y * y + z * z > _STILL**2 or max(abs(roll), abs(pitch), abs(turn)) > _STILL_TURN)
