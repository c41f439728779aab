"""TaskFamily: scenes in which a robot must think, in a building of rooms, doors and roads that is drawn."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..errors import InputError
from ..geometry import Pose2
from ..units import PositiveCount, PositiveMetres
from .building import Building
from .family import Family, Scene
from .ground import Ground
from .scene_text import Table, goal_scenario
from .thing import Point, length_of

_TRIES = 300  # buildings that are drawn until one fits a task


@dataclass(frozen=True, kw_only=True)
class TaskFamily(Family):
    """Tasks in a building: from room to room by roads that the agent knows.

    Attributes:
        planner: The route planner that the family's own mission is given; another mission is given the goal alone.
        rows: Of rooms.
        columns: Of rooms.
        side: Of a room.
        opening: Of a doorway.
    """

    ASIDE: ClassVar[tuple[str, ...]] = (*Family.ASIDE, "planner")

    mission: str = "navigate"
    rules: str = ""
    planner: str = "astar"
    rows: PositiveCount = 3
    columns: PositiveCount = 3
    side: PositiveMetres = 3.6
    opening: PositiveMetres = 1.1

    def drawn(self, rng: np.random.Generator, rooms: int) -> tuple[Building, list[int]]:
        """A building, and some of its rooms, no two alike.

        Raises:
            InputError: It has fewer rooms.
        """
        if self.rows * self.columns < rooms:
            raise InputError(f"{self.rows} x {self.columns} rooms are too few: this task needs {rooms}.")
        building = Building.drawn(rng, self.rows, self.columns, self.side, self.opening)
        return building, rng.permutation(len(building.rooms))[:rooms].tolist()

    def draws(self, index: int, rooms: int) -> Iterator[tuple[np.random.Generator, Building, list[int]]]:
        """Buildings with some of their rooms, until one fits the task; each with the stream that it was drawn from.

        Raises:
            InputError: There are fewer rooms, or none of many buildings fits.
        """
        for attempt in range(_TRIES):
            rng = self.rng(index, f"attempt {attempt}")
            yield rng, *self.drawn(rng, rooms)
        raise InputError(f"none of {_TRIES} buildings of {self.rows} x {self.columns} rooms fits this task.")

    def task(
        self,
        index: int,
        doc: str,
        ground: Ground,
        way: Sequence[Point],
        tables: Iterable[tuple[str, Table]],
        difficulty: Mapping[str, float],
        *,
        ahead: Point | None = None,
        goal: Point | None = None,
        duration: float = 120.0,
        places: Iterable[Table] = (),
        success: Table | None = None,
    ) -> Scene:
        """The scene of a task.

        Args:
            index: Its index.
            doc: One sentence for people.
            ground: What stands there.
            way: The reference, from start to goal [m].
            tables: What agents know and hear of, doors that move, requirements.
            difficulty: How hard it is, beside the reference's `length` [m].
            ahead: What the robot looks at in the beginning [m]; the reference's first corner by default.
            goal: Where the goal is in the beginning [m]; the reference's end by default.
            duration: How long the robot has [s].
            places: More places.
            success: When it succeeds; by default at the goal.
        """
        name, (x, y), corner = self.scene_name(index), way[0], ahead or way[1]
        own = self.mission == type(self).mission
        text = goal_scenario(
            self,
            name,
            doc,
            Pose2(x, y, math.atan2(corner[1] - y, corner[0] - x)),
            goal or way[-1],
            tolerance=0.5,
            duration=duration,
            tables=tables,
            places=places,
            parameters={"goal": "goal", "planner": self.planner} if own else None,
            success=success,
        )
        length = length_of(way)
        hard = {"length": length, **difficulty}
        return Scene(name, text, ground.world(name, doc), hard, tuple(way), length, {"ground": ground})
