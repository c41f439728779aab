"""Detection of new contacts of robots."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .body import FLOOR, GROUND, FreeBody, MocapBody, RobotElements, geom_labels

_APART = 1.0  # [s] minimum time of separation after which a contact of the same pair counts as new
_APPROACH = 0.05  # [m/s] speed of the touched point of a hull towards the other, above which the robot drives into it
_STEEP = 0.5  # [1] maximum vertical component of the normal of a side face of the ground (steeper than 60 deg)


@dataclass(frozen=True)
class Contact:
    """New contact of a robot.

    Attributes:
        t: Time at which the contact began [s].
        robot: Name of the robot.
        other: Name of the touched obstacle or robot.
        driven: Whether the robot drove into the other: by its own motion the touched point of its hull approached it.
            Otherwise the robot was struck, by something that moves or because it was pushed.
    """

    t: float
    robot: str
    other: str
    driven: bool


class ContactDetector:
    """Detector of new contacts of robots, used after physics steps.

    Contacts with the floor do not count, except those of a hull with a side face of ground that a scenario adds. A push
    against several geoms of one object is one contact.

    Attributes:
        before: Velocities of all joints before the last step, because an impact changes them, shape (nv,).
        grounded: Geoms that touch the ground in the present state and should not, by robot; the first of each robot.
        usual: Number of contacts in normal driving, which are those of wheels and casters with the floor. While MuJoCo
            reports this number, most updates can be skipped; not all, because a wheel may lift when the robot touches
            something.
    """

    def __init__(
        self, model: Any, robots: Mapping[str, RobotElements], objects: Mapping[str, MocapBody | FreeBody]
    ) -> None:
        self._robots = robots
        self._names = geom_labels(model, robots)
        self._objects: dict[str, str] = {}  # names of the objects that geoms belong to, by label
        for name, body in objects.items():
            for geom in body.tree if isinstance(body, FreeBody) else body.geoms:
                self._objects[self._names[geom]] = name
        self._hulls = {geom for body in robots.values() for geom in body.hull}
        names = {geom: str(model.geom(geom).name) for geom in range(model.ngeom)}
        self._ground = {g: name.removeprefix(GROUND) for g, name in names.items() if name.startswith(GROUND)}
        self._floor = {geom for geom, name in enumerate(self._names) if name == FLOOR}
        self._off_ground: dict[int, tuple[str, int]] = {}  # robots and IDs of geoms that should not touch the ground
        self.grounded: dict[str, int] = {}
        self.usual = -1
        self.before = np.zeros(model.nv)
        self._touching: dict[tuple[str, str], float] = {}
        self._new: list[Contact] = []

    def begin(self, velocities: memoryview[float]) -> None:
        """Store all velocities before a step, because an impact changes them."""
        self.before[:] = velocities

    def update(self, data: Any, t: float, propelled: Callable[[str], bool]) -> None:
        """Detect new contacts after a step.

        Args:
            data: MjData of the world.
            t: Time after the step [s].
            propelled: Function from a robot's name to whether the robot moves by itself.
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
                        sign = 1.0 if geom == one else -1.0
                        self._touch(data, i, sign, robot, ground, t, propelled)
                    else:
                        self.grounded.setdefault(robot, geom)
                continue
            a, b = names[one], names[two]
            if a == b:
                continue
            for robot, other, sign in ((a, b, 1.0), (b, a, -1.0)):
                if robot in self._robots:
                    plain = False
                    self._touch(data, i, sign, robot, other, t, propelled)
        if plain:
            self.usual = data.ncon

    def allow_ground(self, robot: str, geoms: Collection[int]) -> None:
        """Set the geoms of a robot that may touch the ground."""
        for geom in self._robots[robot].geoms:
            self._off_ground.pop(geom, None)
            if geom not in geoms:
                self._off_ground[geom] = robot, geom

    def join(self, geoms: Collection[int], whole: str) -> None:
        """Count contacts with the geoms of a part, such as a leg, as contacts with the object that it belongs to."""
        for geom in geoms:
            self._names[geom] = whole

    def drain(self) -> list[Contact]:
        """Contacts that began since the last call."""
        new, self._new = self._new, []
        return new

    def _touch(
        self, data: Any, contact: int, sign: float, robot: str, other: str, t: float, propelled: Callable[[str], bool]
    ) -> None:
        pair = robot, self._objects.get(other, other)
        last = self._touching.get(pair)
        self._touching[pair] = t
        if last is None or t - last > _APART:
            towards = sign * data.contact.frame[contact, :3]
            driven = propelled(robot) and self._speed(data, robot, data.contact.pos[contact]) @ towards > _APPROACH
            self._new.append(Contact(t, robot, other, bool(driven)))

    def _speed(self, data: Any, robot: str, point: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        """Velocity before the step of a point of a robot's base, world frame, shape (3,) [m/s]."""
        body = self._robots[robot]
        linear, turning = self.before[body.v : body.v + 3], self.before[body.v + 3 : body.v + 6]
        frame = data.xmat[body.root].reshape(3, 3)
        speed: npt.NDArray[np.float64] = linear + np.cross(frame @ turning, point - data.xpos[body.root])
        return speed
