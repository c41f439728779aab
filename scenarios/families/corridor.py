"""A corridor in which people come towards the robot, walk ahead of it, or pass a door; without a map."""

import numpy as np

from rocs_bt import InputError, PositiveCount, PositiveMetres
from rocs_bt.compare import Block, PeopleFamily, Scene, Walk, one_of

ENCOUNTERS = ("oncoming", "overtaking", "door")


class Corridor(PeopleFamily):
    """A corridor in which people come towards the robot, walk ahead of it, or pass a door; without a map.

    The parameter `encounter` is `oncoming`, `overtaking` (people walk ahead at half their speed, and return from the
    end) or `door` (people come towards the robot through a doorway of the width `door`). The parameter `motion` is
    `polite` (people avoid each other, walls and robots), `blind` (people avoid nothing) or `mixed` (people of both
    kinds). With `middle = 1` the robot starts halfway, in the doorway if there is one.

    Difficulty: number of `people`; `density`: people per floor area [1/m2]; their mean preferred `speed` [m/s];
    `length` of the shortest path without people [m].
    """

    encounter: str = "oncoming"
    people: PositiveCount = 3
    long: PositiveMetres = 16.0
    wide: PositiveMetres = 3.0
    door: PositiveMetres = 1.8

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of(self.encounter, "encounter", ENCOUNTERS)
        if self.encounter == "door" and not self.door < self.wide:
            raise InputError(f"door must be narrower than the corridor of {self.wide:g} m, found {self.door:g} m.")

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        rng = self.rng(index)
        floor = self.hall()
        if self.encounter == "door":
            floor.obstacles += self.doorway()
        goal = (self.long - 1.0, self.wide / 2.0)
        start = self.begin((1.0, self.wide / 2.0), goal)
        walks = self.traffic(rng, floor, start, self.people, self.along)
        doc = f"Along a corridor with {self.people} people: {self.encounter}."
        return self.traffic_scene(index, doc, floor, start, goal, walks)

    def doorway(self) -> list[Block]:
        """The two parts of a wall across the corridor, with a doorway between them."""
        part = (self.wide - self.door) / 2.0
        return [
            Block(f"door_{side}", self.long / 2.0, y, 0.1, part)
            for side, y in (("south", part / 2.0), ("north", self.wide - part / 2.0))
        ]

    def along(self, rng: np.random.Generator, index: int) -> Walk:
        """Sample a person's walk along the corridor."""
        aside = 0.15 if self.encounter == "door" else max(self.wide / 2.0 - 0.9, 0.0)
        y, to_y = (self.wide / 2.0 + rng.uniform(-aside, aside, 2)).tolist()
        near, far = 2.5, self.long - 1.0
        if self.encounter == "overtaking":
            x = float(rng.uniform(near, self.long / 2.0))
            return self.walk(rng, index, (x, y), (far, to_y), deviation=0.2, pace=0.5)
        x = float(rng.uniform(0.6 * self.long, far))
        return self.walk(rng, index, (x, y), (near, to_y), deviation=0.2)
