"""Building: a grid of rooms joined by doors; and TaskFamily: scenes in a building that require route planning."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np

from ..base.errors import InputError
from ..base.geometry import Pose2
from ..base.units import PositiveCount, PositiveMetres
from .family import Family, goal_scenario, position, quantity
from .floor import Floor
from .obstacle import Block, Point, Post, walls_around

WALL_THICKNESS, LEAF_THICKNESS = 0.1, 0.06
"""Thickness of walls, and of door leaves, which slide into the wall [m]."""

_TRIES = 300  # maximum number of sampled buildings per task

Table = dict[str, Any]
Door = tuple[int, int]
"""The two rooms that a door joins, lower number first."""


@dataclass(frozen=True)
class Route:
    """Route over the roads from room to room.

    Attributes:
        rooms: Room numbers; empty if there is no route.
        length: Length [m]; +inf if there is no route.
    """

    rooms: tuple[int, ...] = ()
    length: float = math.inf


@dataclass(frozen=True)
class Building:
    """Rooms in rows and columns, with a doorway in every shared wall.

    Agents know the building as a roadmap: places in the centres of rooms and doorways, roads between them, and doors.

    Attributes:
        rows, columns: Number of rows and columns of rooms.
        side: Side of a room [m].
        opening: Width of a doorway [m].
        offsets: Offset of each doorway from the centre of its wall [m], by door.
    """

    rows: int
    columns: int
    side: float
    opening: float
    offsets: dict[Door, float] = field(default_factory=dict)

    @staticmethod
    def sample(rng: np.random.Generator, rows: int, columns: int, side: float, opening: float) -> Building:
        """Sample a building with doorways at random positions in their walls, beside which the open leaf has room."""
        made = Building(rows, columns, side, opening)
        most = max(0.5 * side - 1.5 * opening - 0.1, 0.0)
        offsets = {door: float(rng.uniform(-most, most)) for door in made.doors()}
        return Building(rows, columns, side, opening, offsets)

    @property
    def rooms(self) -> range:
        """Room numbers, row by row."""
        return range(self.rows * self.columns)

    def doors(self) -> list[Door]:
        """All doors."""
        beside = [(i, i + 1) for i in self.rooms if (i + 1) % self.columns]
        above = [(i, i + self.columns) for i in self.rooms if i + self.columns in self.rooms]
        return beside + above

    def middle(self, room: int) -> Point:
        """Centre of a room [m]."""
        row, column = divmod(room, self.columns)
        return (column + 0.5) * self.side, (row + 0.5) * self.side

    def doorway(self, door: Door) -> Point:
        """Centre of a doorway [m]."""
        (x, y), (u, v) = self.middle(door[0]), self.middle(door[1])
        aside = self.offsets.get(door, 0.0)
        return (0.5 * (x + u), y + aside) if y == v else (x + aside, 0.5 * (y + v))

    @staticmethod
    def room_name(room: int) -> str:
        """Name of the place in the centre of a room."""
        return f"room_{room}"

    @staticmethod
    def gate_name(door: Door) -> str:
        """Name of the place in a doorway."""
        return f"gate_{door[0]}_{door[1]}"

    @staticmethod
    def door_name(door: Door) -> str:
        """Name of the door of a doorway."""
        return f"door_{door[0]}_{door[1]}"

    def floor(self) -> Floor:
        """Floor and walls with doorways; a scene adds the door leaves."""
        wide, deep = self.columns * self.side, self.rows * self.side
        floor = Floor((-0.5, -0.5), (wide + 0.5, deep + 0.5))
        floor.obstacles += walls_around((0.0, 0.0), (wide, deep), thickness=WALL_THICKNESS)
        for door in self.doors():
            floor.obstacles += self._wall(door)
        return floor

    def leaf(self, door: Door, *, closed: bool) -> Block:
        """Leaf of a door: in the doorway if `closed`, else beside it."""
        x, y = self.doorway(door)
        aside = 0.0 if closed else self.opening + 0.05
        if self._is_vertical(door):
            return Block(self.door_name(door), x, y + aside, LEAF_THICKNESS, self.opening)
        return Block(self.door_name(door), x + aside, y, self.opening, LEAF_THICKNESS)

    def closing(self, door: Door, at: float) -> Table:
        """Actor table of a door that begins to close at a time [s], or later when no robot blocks it."""
        begin, end = self.leaf(door, closed=False), self.leaf(door, closed=True)
        return {
            "name": begin.name,
            "script": "slide",
            **position((begin.x, begin.y)),
            "to_x": quantity(end.x, "m"),
            "to_y": quantity(end.y, "m"),
            "depart_at": quantity(at, "s"),
            "duration": "1 s",
            "wait_distance": quantity(0.5 * self.opening + 0.5, "m"),
            "at_target": "shut",
        }

    def facts(self) -> list[Table]:
        """`[[fact]]` tables of the places, roads and doors that agents know."""
        found: list[Table] = [
            {"node": self.room_name(room), "kind": "place", "pose": position(self.middle(room))} for room in self.rooms
        ]
        for door in self.doors():
            roads = [{"to": self.room_name(room), "both_ways": True} for room in door]
            gate = {
                "node": self.gate_name(door),
                "kind": "place",
                "pose": position(self.doorway(door)),
                "connects": roads,
            }
            leads = [self.gate_name(door), *(self.room_name(room) for room in door)]
            found += [gate, {"node": self.door_name(door), "kind": "door", "open": True, "leads_to": leads}]
        return found

    def path(self, rooms: Iterable[int]) -> list[Point]:
        """Corners of the path through a sequence of rooms: room centres and the doorways between them."""
        names = list(rooms)
        points = [self.middle(names[0])]
        for a, b in pairwise(names):
            points += [self.doorway(_between(a, b)), self.middle(b)]
        return points

    def shortest(self, start: int, goal: int, closed: Iterable[Door] = ()) -> Route:
        """Shortest route over the roads, with some doors closed (Dijkstra)."""
        closed, best = set(closed), {start: Route((start,), 0.0)}
        open_ = [start]
        while open_:
            here = min(open_, key=lambda room: best[room].length)
            open_.remove(here)
            for door in self.doors():
                if here not in door or door in closed:
                    continue
                there = door[0] if door[1] == here else door[1]
                gate = self.doorway(door)
                length = best[here].length + math.dist(self.middle(here), gate) + math.dist(gate, self.middle(there))
                if there not in best or length < best[there].length - 1e-12:
                    best[there] = Route((*best[here].rooms, there), length)
                    open_.append(there)
        return best.get(goal, Route())

    def sample_closed(self, rng: np.random.Generator, start: int, goal: int, count: int) -> list[Door]:
        """Sample doors to close, each from the shortest route past the earlier ones; fewer if no route is left."""
        closed: list[Door] = []
        while len(closed) < count and (rooms := self.shortest(start, goal, closed).rooms):
            doors = [_between(a, b) for a, b in pairwise(rooms)]
            closed.append(doors[int(rng.integers(len(doors)))])
        return closed

    def _is_vertical(self, door: Door) -> bool:
        return door[1] == door[0] + 1

    def _wall(self, door: Door) -> list[Post | Block]:
        """The two wall parts beside a doorway."""
        (x, y), (u, v) = self.doorway(door), self.middle(door[0])
        along = y if self._is_vertical(door) else x
        begin = (v if self._is_vertical(door) else u) - 0.5 * self.side
        parts = [(begin, along - 0.5 * self.opening), (along + 0.5 * self.opening, begin + self.side)]
        return [
            Block(f"{self.door_name(door)}_wall{i}", x, 0.5 * (a + b), WALL_THICKNESS, b - a)
            if self._is_vertical(door)
            else Block(f"{self.door_name(door)}_wall{i}", 0.5 * (a + b), y, b - a, WALL_THICKNESS)
            for i, (a, b) in enumerate(parts)
        ]


def _between(room: int, other: int) -> Door:
    return min(room, other), max(room, other)


class TaskFamily(Family):
    """Base class of families of tasks in a building with roads that the agent knows.

    Attributes:
        planner: Route planner that the default mission of the family uses; other missions get only the goal.
        rows: Number of rows of rooms.
        columns: Number of columns of rooms.
        side: Side of a room.
        opening: Width of a doorway.
    """

    NOT_SAMPLED: ClassVar[tuple[str, ...]] = (*Family.NOT_SAMPLED, "planner")

    mission: str = "navigate"
    rules: str = ""
    planner: str = "astar"
    rows: PositiveCount = 3
    columns: PositiveCount = 3
    side: PositiveMetres = 3.6
    opening: PositiveMetres = 1.1

    def sample(self, rng: np.random.Generator, rooms: int) -> tuple[Building, list[int]]:
        """Sample a building, and `rooms` different rooms in it.

        Raises:
            InputError: The building has fewer rooms.
        """
        if self.rows * self.columns < rooms:
            raise InputError(f"{self.rows} x {self.columns} rooms are too few: this task needs {rooms}.")
        building = Building.sample(rng, self.rows, self.columns, self.side, self.opening)
        return building, rng.permutation(len(building.rooms))[:rooms].tolist()

    def sample_until_fit(self, index: int, rooms: int) -> Iterator[tuple[np.random.Generator, Building, list[int]]]:
        """Yield random stream, sampled building and rooms, again and again; the caller stops at the first that fits."""
        for attempt in range(_TRIES):
            rng = self.rng(index, f"attempt {attempt}")
            yield rng, *self.sample(rng, rooms)
        raise InputError(f"none of {_TRIES} sampled buildings of {self.rows} x {self.columns} rooms fits this task.")

    def task(
        self,
        index: int,
        doc: str,
        path: Sequence[Point],
        *,
        ahead: Point | None = None,
        goal: Point | None = None,
        agent: Mapping[str, Any] | None = None,
    ) -> dict[str, Any]:
        """Scenario of a task. Families add facts, doors that move, and places.

        Args:
            index: Index of the scene.
            doc: One-sentence description.
            path: Reference path from start to goal [m].
            ahead: Point that the robot faces at the start [m]; the first corner of the reference path by default.
            goal: Goal position at the start [m]; the end of the reference path by default.
            agent: Additional or replaced keys of the agent's table.
        """
        (x, y), corner = path[0], ahead or path[1]
        start = Pose2(x, y, math.atan2(corner[1] - y, corner[0] - x))
        own = {"parameters": {"goal": "goal", "planner": self.planner}} if self.mission == type(self).mission else {}
        return goal_scenario(
            self,
            self.scene_name(index),
            doc,
            start,
            goal or path[-1],
            tolerance=0.5,
            duration=120.0,
            agent={**own, **(agent or {})},
        )
