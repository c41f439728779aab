"""A hall that people cross from the side; the robot drives along it, without a map."""

import numpy as np

from rocs_bt import PositiveCount
from rocs_bt.compare import PeopleFamily, Scene, Walk


class Crossing(PeopleFamily):
    """A hall that people cross from the side; the robot drives along it, without a map.

    The parameter `motion` is `polite` (people avoid each other, walls and robots), `blind` (people avoid nothing) or
    `mixed` (people of both kinds). With `middle = 1` the robot starts in the middle of the hall.

    Difficulty: number of `people`; `density`: people per floor area [1/m2]; their mean preferred `speed` [m/s];
    `length` of the shortest path without people [m].
    """

    least = (6.0, 2.0)
    people: PositiveCount = 6

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        rng = self.rng(index)
        floor = self.hall()
        y, to_y = rng.uniform(0.4 * self.wide, 0.6 * self.wide, 2).tolist()
        start, goal = self.begin((1.0, y), (self.long - 1.0, to_y)), (self.long - 1.0, to_y)
        walks = self.traffic(rng, floor, start, self.people, self.across)
        return self.traffic_scene(index, f"Along a hall that {self.people} people cross.", floor, start, goal, walks)

    def across(self, rng: np.random.Generator, index: int) -> Walk:
        """Sample a person's walk from one long wall to the other; each person has a lane of its own."""
        lane = (self.long - 5.0) / self.people
        x, to_x = (3.0 + lane * (index + rng.uniform(0.0, 1.0, 2))).tolist()
        ends = [(x, 1.0), (to_x, self.wide - 1.0)]
        start, end = ends if rng.random() < 0.5 else ends[::-1]
        return self.walk(rng, index, start, end, deviation=0.4)
