"""Scripted objects: doors, boxes and people that scripts move along the floor; contacts do not move them.

A thing is a mocap body of the world. A script says each control period how fast it goes, and the world moves it on in
each physics step, so that a robot is touched, and not jumped at.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ..drivers import read_parameters
from ..drivers.mujoco import MujocoWorld
from ..errors import Fault, InputError, UnknownName, unknown
from ..geometry import Pose2
from ..units import Metres, MetresPerSecond, Seconds

Vector = tuple[float, float]


class ScriptedObject(ABC):
    """A script that moves one object.

    Args:
        name: Name of the object in the world.
        world: The world; a script may read ground truth.
        start: Start pose.
        rng: Its own random stream.
        period: Control period [s].
    """

    Parameters: ClassVar[type]

    def __init__(self, name: str, world: MujocoWorld, start: Pose2, rng: np.random.Generator, period: float) -> None:
        self.name = name
        self.world = world
        self.start = start
        self.rng = rng
        self.period = period
        world.place_object(name, start)

    @abstractmethod
    def velocity(self, t: float, at: Vector) -> Vector:
        """How fast it goes during the next period [m/s], world frame.

        Args:
            t: The time [s].
            at: Where it is [m].
        """

    def step(self, t: float) -> None:
        """Carry it on for one control period."""
        pose = self.world.object_pose(self.name)
        self.world.set_object_velocity(self.name, self.velocity(t, (pose.x, pose.y)))

    def towards(self, at: Vector, target: Vector) -> Vector:
        """The velocity [m/s] that brings it to a point [m] within one period."""
        return (target[0] - at[0]) / self.period, (target[1] - at[1]) / self.period


@dataclass(frozen=True, kw_only=True)
class SlideParameters:
    """What slide takes.

    Attributes:
        to_x, to_y: Where it goes [m].
        at: When it sets out [s].
        lasts: How long it is under way [s].
        back_at: When it sets out for where it came from [s]; never by default.
        yields: It stands while a robot is nearer than this to where it goes [m], as doors with sensors do.
    """

    to_x: Metres
    to_y: Metres
    at: Seconds
    lasts: Seconds = 1.0
    back_at: Seconds = math.inf
    yields: Metres = 0.0

    def __post_init__(self) -> None:
        if not (self.at >= 0.0 and 0.0 < self.lasts < math.inf and self.back_at >= self.at + self.lasts):
            raise InputError(
                Fault(
                    "a slide sets out at 0 s or later, lasts a while, and goes back only after that; found at "
                    f"{self.at:g} s for {self.lasts:g} s, and back at {self.back_at:g} s."
                )
            )


class Slide(ScriptedObject):
    """A door or a box that goes straight from one place to another at a given time, and perhaps back."""

    Parameters = SlideParameters

    def __init__(self, *args: Any, parameters: SlideParameters) -> None:
        super().__init__(*args)
        self._p = parameters
        self._share = 0.0  # of its way

    def velocity(self, t: float, at: Vector) -> Vector:
        p, then, x, y = self._p, t + self.period, self.start.x, self.start.y
        back = then > p.back_at
        target, since = ((x, y), p.back_at) if back else ((p.to_x, p.to_y), p.at)
        if then > since and all(math.dist(target, pose[:2]) >= p.yields for pose in self._robots()):
            step = min(self.period, then - since) / p.lasts
            self._share = max(self._share - step, 0.0) if back else min(self._share + step, 1.0)
        return self.towards(at, (x + self._share * (p.to_x - x), y + self._share * (p.to_y - y)))

    def _robots(self) -> list[Pose2]:
        return [self.world.pose(name) for name in self.world.robots] if self._p.yields else []


@dataclass(frozen=True, kw_only=True)
class PolynomialParameters:
    """What polynomial takes.

    Attributes:
        to_x, to_y: The other end of its way [m].
        speed: Along its way [m/s].
        bend: How far its way may stray from the straight line, at most [m].
        order: Of the polynomial that it strays by.
    """

    to_x: Metres
    to_y: Metres
    speed: MetresPerSecond = 1.0
    bend: Metres = 0.0
    order: int = 3

    def __post_init__(self) -> None:
        if not (0.0 < self.speed < math.inf and 0.0 <= self.bend < math.inf and 1 <= self.order <= 9):
            raise InputError(
                Fault(
                    "speed must be positive, bend 0 or more, and order 1 to 9, found "
                    f"{self.speed:g} m/s, {self.bend:g} m and {self.order}."
                )
            )


class Polynomial(ScriptedObject):
    """Goes to and fro on a curve that strays from a straight line by a random polynomial of the way covered.

    The kind of motion of DynaBARN's obstacles (Nair et al., DynaBARN: Benchmarking Metric Ground Navigation in Dynamic
    Environments, SSRR 2022); it meets its ends exactly and is as fast everywhere.
    """

    Parameters = PolynomialParameters
    _KNOTS = 200

    def __init__(self, *args: Any, parameters: PolynomialParameters) -> None:
        super().__init__(*args)
        p = self._p = parameters
        along = np.linspace(0.0, 1.0, self._KNOTS + 1)
        stray = np.polynomial.Polynomial(self.rng.uniform(-1.0, 1.0, p.order + 1))(2.0 * along - 1.0)
        stray *= along * (1.0 - along)
        aside = p.bend * self.rng.uniform(0.5, 1.0) * stray / max(float(np.abs(stray).max()), 1e-12)
        dx, dy = p.to_x - self.start.x, p.to_y - self.start.y
        length = max(math.hypot(dx, dy), 1e-9)
        self._points = np.stack(
            [self.start.x + along * dx - aside * dy / length, self.start.y + along * dy + aside * dx / length], axis=1
        )
        steps = np.hypot(*np.diff(self._points, axis=0).T)
        self._way = np.concatenate([[0.0], np.cumsum(steps)])
        self._begin = float(self.rng.uniform(0.0, 2.0 * self._way[-1]))  # not all are at their start at once
        self.world.place_object(self.name, Pose2(*self._place(0.0), self.start.yaw))

    def velocity(self, t: float, at: Vector) -> Vector:
        return self.towards(at, self._place(t + self.period))

    def _place(self, t: float) -> Vector:
        length = float(self._way[-1])
        covered = math.fmod(self._begin + self._p.speed * t, 2.0 * length)
        covered = min(covered, 2.0 * length - covered)
        x, y = (float(np.interp(covered, self._way, self._points[:, axis])) for axis in (0, 1))
        return x, y


@dataclass(frozen=True, kw_only=True)
class SocialForceParameters:
    """What social_force takes.

    Attributes:
        to_x, to_y: Where it walks to, before it walks back [m].
        speed: That it likes to walk at [m/s].
        radius: Of its body [m].
        sees_robots: Whether it makes way for robots as for people.
    """

    to_x: Metres
    to_y: Metres
    speed: MetresPerSecond = 1.3
    radius: Metres = 0.25
    sees_robots: int = 1

    def __post_init__(self) -> None:
        if not (0.0 < self.speed < math.inf and 0.0 < self.radius < math.inf and self.sees_robots in (0, 1)):
            raise InputError(
                Fault(
                    "speed and radius must be positive and sees_robots 0 or 1, found "
                    f"{self.speed:g} m/s, {self.radius:g} m and {self.sees_robots}."
                )
            )


class SocialForce(ScriptedObject):
    """Walks to and fro, and makes way for people, robots and walls, as pedestrians do.

    The circular social force, seen less behind than ahead, with the numbers that were fitted to videos of pedestrians
    (Johansson, Helbing and Shukla, Specification of the Social Force Pedestrian Model by Evolutionary Adjustment to
    Video Tracking Data, 2007: A = 0.42 m/s2, B = 1.65 m, lambda = 0.12); walls as in Helbing and Molnar, Social force
    model for pedestrian dynamics, 1995 (U = 10 m2/s2, R = 0.2 m).
    """

    Parameters = SocialForceParameters
    _RELAX = 0.5  # [s] in which it gets to its speed; Helbing and Molnar
    _PUSH, _FADE, _BEHIND = 0.42, 1.65, 0.12  # [m/s2], [m], -
    _WALL, _WALL_FADE = 50.0, 0.2  # [m/s2], [m]
    _SIDESTEP = 0.6  # of the push of what is straight ahead; without it two who meet, or a pillar, stop them for ever
    _ARRIVED = 0.4  # [m]

    def __init__(self, *args: Any, parameters: SocialForceParameters) -> None:
        super().__init__(*args)
        self._p = parameters
        self._ends = ((self.start.x, self.start.y), (parameters.to_x, parameters.to_y))
        self._heading = 1
        self._speed = parameters.speed * float(self.rng.uniform(0.8, 1.2))
        self._v = np.zeros(2)

    def velocity(self, t: float, at: Vector) -> Vector:
        here, target = np.array(at), np.array(self._ends[self._heading])
        if math.dist(at, self._ends[self._heading]) < self._ARRIVED:
            self._heading = 1 - self._heading
        wish = target - here
        wish *= self._speed / max(float(np.linalg.norm(wish)), 1e-9)
        ahead = wish / self._speed
        push = (wish - self._v) / self._RELAX + self._others(here, ahead) + self._walls(here, ahead)
        self._v = self._v + push * self.period
        fastest = 1.3 * self._speed / max(float(np.linalg.norm(self._v)), 1e-9)
        self._v *= min(fastest, 1.0)
        return float(self._v[0]), float(self._v[1])

    def _others(self, here: Any, ahead: Any) -> Any:
        world = self.world
        places = [world.object_pose(name) for name in world.objects if name != self.name]
        places += [world.pose(name) for name in world.robots] if self._p.sees_robots else []
        push = np.zeros(2)
        for pose in places:
            away = here - (pose.x, pose.y)
            distance = max(float(np.linalg.norm(away)), 1e-3)
            if distance < 5.0:
                away /= distance
                seen = self._BEHIND + (1.0 - self._BEHIND) * (1.0 - float(ahead @ away)) / 2.0
                force = self._PUSH * math.exp((2.0 * self._p.radius - distance) / self._FADE) * seen
                push += self._around(force * away, ahead)
                # Bodies do not pass through each other.
                push += 10.0 * max(2.2 * self._p.radius - distance, 0.0) * away / self._p.radius
        return push

    def _around(self, push: Any, ahead: Any) -> Any:
        """A push, and for what is straight ahead a share of it to the right: who meets head-on steps aside."""
        against = max(-float(push @ ahead), 0.0)
        return push + self._SIDESTEP * against * np.array([ahead[1], -ahead[0]])

    def _walls(self, here: Any, ahead: Any) -> Any:
        """The push of what cannot move: down the slope of the distance to it."""
        room, step = self.world.room(*here), 0.05
        gap = room - self._p.radius
        if gap > 1.0:
            return np.zeros(2)
        x, y = here
        slope = np.array(
            [
                self.world.room(x + step, y) - self.world.room(x - step, y),
                self.world.room(x, y + step) - self.world.room(x, y - step),
            ]
        )
        size = float(np.linalg.norm(slope))
        push = self._WALL * math.exp(-max(gap, -0.2) / self._WALL_FADE)
        return self._around(min(push, 20.0) * slope / size, ahead) if size > 0.0 else np.zeros(2)


SCRIPTED_OBJECTS: Mapping[str, Any] = {"slide": Slide, "polynomial": Polynomial, "social_force": SocialForce}


def make_scripted_object(
    script: str,
    parameters: Mapping[str, Any],
    *,
    name: str,
    world: MujocoWorld,
    start: Pose2,
    rng: np.random.Generator,
    period: float,
) -> ScriptedObject:
    """A scripted object by its script's name.

    Raises:
        InputError: No such script, parameters that do not fit it, or no such thing in the world; with every fault.
    """
    if script not in SCRIPTED_OBJECTS:
        raise UnknownName(unknown("script for a thing", script, SCRIPTED_OBJECTS))
    cls = SCRIPTED_OBJECTS[script]
    wanted = read_parameters(cls.Parameters, parameters, f"{script} '{name}'")
    made: ScriptedObject = cls(name, world, start, rng, period, parameters=wanted)
    return made
