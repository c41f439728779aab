"""Base classes of families in which scripted people, or other bodies, walk while the robot drives to a goal."""

from __future__ import annotations

import math
from abc import ABC
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, TypeVar

import numpy as np

from ..base.errors import InputError
from ..base.geometry import Pose2
from ..base.units import Count, PositiveMetres, PositiveMetresPerSecond
from ..simulation.people import LEG_OFFSET
from .family import Family, Scene, goal_scenario, position, quantity
from .floor import Floor
from .obstacle import Point, Post, walls_around

MOTIONS = ("polite", "mixed", "blind")
"""Motions of people: they avoid each other and robots, both kinds in turn, or they avoid nothing."""

PERSON = 0.25
"""Radius of a person [m]."""

_HEIGHT, _LEG = 1.7, 0.06  # [m] height of a person, radius of a leg
_DISC = 0.32  # [m] radius of the disc that the reference path is for
_FROM_ROBOT = 1.5  # [m] from the centre of the robot to the outline of a body, at the start
_SPACE = 0.4  # [m] beside a body at its start, and beside a line that a blind body walks on
_TRIES = 5000

T = TypeVar("T")


@dataclass(frozen=True, kw_only=True)
class Walk:
    """Walk of a person, or another upright cylinder, back and forth between two points; it begins at the first.

    Attributes:
        start, end: Ends of the walk [m].
        speed: Preferred walking speed [m/s].
        blind: Whether it avoids nothing, and follows a random polynomial curve.
        deviation: Maximum lateral deviation of that curve from the straight line [m].
        order: Order of the polynomial.
        radius: Radius of the body [m].
        legs: Whether it has two legs that step in turn, instead of a solid body.
    """

    start: Point
    end: Point
    speed: float
    blind: bool
    deviation: float = 0.6
    order: int = 3
    radius: float = PERSON
    legs: bool = False

    def actors(self, name: str) -> list[dict[str, Any]]:
        """Tables of the scenario that move the body."""
        ends = {"to_x": quantity(self.end[0], "m"), "to_y": quantity(self.end[1], "m")}
        if self.blind:
            own = {"script": "polynomial", "deviation": quantity(self.deviation, "m"), "order": self.order}
        else:
            own = {"script": "social_force", "radius": quantity(self.radius, "m")}
        body = {"name": name, **own, **position(self.start), **ends, "speed": quantity(self.speed, "m/s")}
        legs = zip(("left", "right"), self.bodies(name)[1:], strict=False)  # without legs there is one body
        of = {"script": "leg", "person": name}
        return [body, *({"name": leg.name, **of, "side": side, **position((leg.x, leg.y))} for side, leg in legs)]

    def bodies(self, name: str) -> list[Post]:
        """Bodies that the scenario moves, at their start."""
        (x, y), (to_x, to_y) = self.start, self.end
        ahead = math.atan2(to_y - y, to_x - x)
        aside = -LEG_OFFSET * math.sin(ahead), LEG_OFFSET * math.cos(ahead)
        sides = (("left", 1.0), ("right", -1.0)) if self.legs else ()
        legs = [Post(f"{name}_{of}", x + s * aside[0], y + s * aside[1], _LEG, _HEIGHT / 2.0) for of, s in sides]
        return [Post(name, x, y, self.radius, _HEIGHT, solid=not legs), *legs]

    def free(self, floor: Floor, robot: Point, others: Sequence[Walk]) -> bool:
        """Whether the start is away from robot, posts and others, and a blind walk from posts on all of its way."""
        if math.dist(self.start, robot) < _FROM_ROBOT + self.radius:
            return False
        if any(math.dist(self.start, o.start) < self.radius + o.radius + _SPACE for o in others):
            return False
        aside = self.deviation if self.blind else 0.0
        line = [self.start, self.end if self.blind else self.start]
        return floor.clearance(line) > self.radius + aside + 0.1


class TrafficFamily(Family, ABC):
    """Base class of families in which bodies walk while the robot drives to a goal, without a map.

    Difficulty: number of `people`; `density`: people per floor area [1/m2]; their mean preferred `speed` [m/s];
    `length` of the shortest path without people [m].

    Attributes:
        long, wide: Length and width of the hall, inside its walls [m].
        middle: 1 if the robot starts in the middle of the traffic: with the planner `none`, the rate at which others
            run into a stationary robot.
    """

    least: ClassVar[tuple[float, float]] = (5.0, 1.0)
    """Smallest length and width of a hall of this family [m]."""

    bodies: ClassVar[str] = "people"
    """What walks."""

    long: PositiveMetres = 12.0
    wide: PositiveMetres = 7.0
    middle: Count = 0

    def __post_init__(self) -> None:
        for name, least in zip(("long", "wide"), self.least, strict=True):
            if not (found := getattr(self, name)) >= least:
                raise InputError(f"{name} must be at least {least:g} m in {self.name}, found {found:g} m.")
        switch(self.middle, "middle")

    def hall(self) -> Floor:
        """Floor with four walls; the corner in the south-west is the origin."""
        outside = (self.long + 0.5, self.wide + 0.5)
        return Floor((-0.5, -0.5), outside, walls_around((0.0, 0.0), (self.long, self.wide)))

    def fitting(self, what: str, sample: Callable[[], T], fits: Callable[[T], bool]) -> T:
        """The first sample that fits.

        Raises:
            InputError: None of many does: the hall has no room for what is sampled.
        """
        for _ in range(_TRIES):
            if fits(one := sample()):
                return one
        raise InputError(f"{self.name} has no room for {what}; make the hall larger.")

    def traffic(
        self,
        rng: np.random.Generator,
        floor: Floor,
        start: Point,
        count: int,
        walk: Callable[[np.random.Generator, int], Walk],
    ) -> list[Walk]:
        """Sample walks, each until it begins away from robot, posts and the others.

        Args:
            rng: Random stream of the scene.
            floor: Floor with its obstacles.
            start: Start of the robot [m].
            count: Number of walks.
            walk: Function that samples the walk with an index.

        Raises:
            InputError: There is no room for so many.
        """
        made: list[Walk] = []
        for index in range(count):
            one = self.fitting(
                f"{count} {self.bodies}", partial(walk, rng, index), lambda w: w.free(floor, start, made)
            )
            made.append(one)
        return made

    def begin(self, start: Point, goal: Point) -> Point:
        """Start of the robot [m]: one end of its way, or the middle."""
        return ((start[0] + goal[0]) / 2.0, (start[1] + goal[1]) / 2.0) if self.middle else start

    def traffic_scene(
        self, index: int, doc: str, floor: Floor, start: Point, goal: Point, walks: Sequence[Walk]
    ) -> Scene:
        """Scene with an index: the robot drives from start to goal [m] while others walk."""
        path = floor.grid(0.1).shortest(start, goal, _DISC)
        if path is None:
            raise InputError(f"{self.scene_name(index)} has no path for a robot of radius {_DISC} m; make it wider.")
        named = [(f"P{i}", walk) for i, walk in enumerate(walks)]
        floor.actors += [body for name, walk in named for body in walk.bodies(name)]
        begin = Pose2(*start, 0.0)
        scenario = goal_scenario(self, self.scene_name(index), doc, begin, goal, tolerance=0.5, duration=90.0)
        difficulty = {
            "people": float(len(walks)),
            "density": len(walks) / (self.long * self.wide),
            "speed": float(np.mean([walk.speed for walk in walks])),
            "length": path.length,
        }
        actors = [table for name, walk in named for table in walk.actors(name)]
        return Scene(scenario | {"actor": actors}, floor, difficulty, path.points)


class PeopleFamily(TrafficFamily, ABC):
    """Base class of families in which people walk.

    Attributes:
        motion: `polite` (people avoid each other, walls and robots), `blind` (they avoid nothing and walk on polynomial
            curves) or `mixed` (both kinds in turn).
        speed: Mean preferred walking speed [m/s].
        legs: 1 if people have two legs, which step in turn, instead of the body of a post.
    """

    motion: str = "mixed"
    speed: PositiveMetresPerSecond = 0.8
    legs: Count = 0

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of(self.motion, "motion", MOTIONS)
        switch(self.legs, "legs")

    def walk(
        self,
        rng: np.random.Generator,
        index: int,
        start: Point,
        end: Point,
        *,
        deviation: float = 0.6,
        pace: float = 1.0,
    ) -> Walk:
        """Walk of the person with an index, with a sampled speed; `pace` is a factor of the mean speed."""
        blind = self.motion == "blind" or (self.motion == "mixed" and index % 2 == 1)
        speed = pace * self.speed * float(rng.uniform(0.7, 1.3))
        return Walk(start=start, end=end, speed=speed, blind=blind, deviation=deviation, legs=bool(self.legs))


def switch(value: int, name: str) -> None:
    """Refuse the value of a parameter that is neither 0 nor 1.

    Raises:
        InputError: With the name and the value.
    """
    if value not in (0, 1):
        raise InputError(f"{name} must be 0 or 1, found {value}.")


def one_of(value: str, name: str, values: Sequence[str]) -> None:
    """Refuse the value of a parameter that is none of some values.

    Raises:
        InputError: With the values that exist.
    """
    if value not in values:
        raise InputError(f"{name} must be {', '.join(values[:-1])} or {values[-1]}, found '{value}'.")
