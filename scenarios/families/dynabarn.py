"""A field of cylinders on random polynomial curves, which do not see the robot; without a map."""

from math import dist

import numpy as np

from rocs_bt import PositiveMetres
from rocs_bt.compare import Scene, TrafficFamily, Walk, one_of

RADIUS = 0.5  # [m]
LEVELS = {  # number of cylinders, mean speed [m/s], order of the polynomials, largest deviation [m]
    "easy": (6, 0.3, 2, 0.4),
    "medium": (9, 0.5, 4, 0.7),
    "hard": (12, 0.8, 6, 1.0),
}


class Dynabarn(TrafficFamily):
    """A field of cylinders on random polynomial curves, which do not see the robot; without a map.

    The kind of obstacles is that of DynaBARN (Nair et al., SSRR 2022): cylinders with a radius of 0.5 m, each with its
    own speed and curve. The parameter `level` is `easy`, `medium` or `hard`: more, faster cylinders on curves of higher
    order. A contact counts, as everywhere. With `middle = 1` the robot starts in the middle of the field.

    Difficulty: number of cylinders, `people`; `density`: cylinders per floor area [1/m2]; their mean `speed` [m/s];
    `length` of the shortest path without cylinders [m].
    """

    least = (6.0, 4.0)
    bodies = "cylinders"
    level: str = "medium"
    long: PositiveMetres = 14.0
    wide: PositiveMetres = 10.0

    def __post_init__(self) -> None:
        super().__post_init__()
        one_of(self.level, "level", list(LEVELS))

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        rng = self.rng(index)
        floor = self.hall()
        goal = (self.long - 1.0, float(rng.uniform(2.0, self.wide - 2.0)))
        start = self.begin((1.0, float(rng.uniform(2.0, self.wide - 2.0))), goal)
        walks = self.traffic(rng, floor, start, LEVELS[self.level][0], self.curve)
        doc = f"Through a field of {len(walks)} cylinders on random curves."
        return self.traffic_scene(index, doc, floor, start, goal, walks)

    def curve(self, rng: np.random.Generator, _: int) -> Walk:
        """Sample a cylinder's curve through the field."""
        _, speed, order, deviation = LEVELS[self.level]
        margin = RADIUS + deviation + 0.1
        low, high = (2.0 + margin, margin), (self.long - margin, self.wide - margin)
        x, y, to_x, to_y = self.fitting(
            "curves of 3 m", lambda: rng.uniform(low * 2, high * 2).tolist(), lambda e: dist(e[:2], e[2:]) > 3.0
        )
        pace = speed * float(rng.uniform(0.7, 1.3))
        return Walk(
            start=(x, y),
            end=(to_x, to_y),
            speed=pace,
            blind=True,
            deviation=deviation,
            order=order,
            radius=RADIUS,
        )
