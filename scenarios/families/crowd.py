"""A hall in which people walk; the robot drives from one end to the other, without a map."""

from math import dist

import numpy as np

from rocs_bt.compare import PeopleFamily, Post, Scene, Walk, one_of

DENSITIES = {"sparse": 0.05, "normal": 0.095, "dense": 0.165}  # [1/m2] 4, 8 and 14 people in the default hall


class Crowd(PeopleFamily):
    """A hall in which people walk; the robot drives from one end to the other, without a map.

    The parameter `motion` is `polite` (people avoid each other, walls and robots), `blind` (people avoid nothing) or
    `mixed` (people of both kinds); the parameter `density` is `sparse`, `normal` or `dense` (4, 8 or 14 people in a
    hall of this size). With `legs = 1` people have two legs; with `middle = 1` the robot starts in the middle of the
    hall.

    Difficulty: number of `people`; `density`: people per floor area [1/m2]; their mean preferred `speed` [m/s];
    `length` of the shortest path without people [m].
    """

    least = (6.0, 3.0)
    density: str = "normal"

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of(self.density, "density", list(DENSITIES))

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        rng = self.rng(index)
        goal = (self.long - 1.0, self.across(rng))
        start = self.begin((1.0, self.across(rng)), goal)
        floor = self.hall()
        floor.obstacles += self.pillars(rng, start)
        people = max(round(DENSITIES[self.density] * self.long * self.wide), 1)
        walks = self.traffic(rng, floor, start, people, self.through)
        return self.traffic_scene(index, f"Through a hall in which {people} people walk.", floor, start, goal, walks)

    def across(self, rng: np.random.Generator) -> float:
        """Sample a position between the long walls [m]."""
        return float(rng.uniform(1.2, self.wide - 1.2))

    def pillars(self, rng: np.random.Generator, start: tuple[float, float]) -> list[Post]:
        """Sample a few pillars, away from each other and from the start of the robot."""
        made: list[Post] = []

        def away(at: list[float]) -> bool:
            return all(dist(at, other) > 1.2 for other in (start, *((post.x, post.y) for post in made)))

        for number in range(3):
            x, y = self.fitting(
                "3 pillars", lambda: rng.uniform((3.0, 1.5), (self.long - 3.0, self.wide - 1.5)).tolist(), away
            )
            made.append(Post(f"pillar_{number}", x, y, 0.2, 2.0))
        return made

    def through(self, rng: np.random.Generator, index: int) -> Walk:
        """Sample a person's walk across the hall."""
        ends = (2.8, 1.0) * 2, (self.long - 1.0, self.wide - 1.0) * 2
        x, y, to_x, to_y = self.fitting(
            "walks of 3 m", lambda: rng.uniform(*ends).tolist(), lambda e: dist(e[:2], e[2:]) > 3.0
        )
        return self.walk(rng, index, (x, y), (to_x, to_y))
