"""A hall in which people walk; the robot drives from one end to the other, without a map."""

from dataclasses import dataclass
from math import dist

import numpy as np

from rocs_bt import Pose2
from rocs_bt.compare import Block, Family, Ground, Post, Scene, goal_scenario, position, quantity, walls_around
from rocs_bt.errors import InputError
from rocs_bt.units import Count, PositiveMetres, PositiveMetresPerSecond

RADIUS, HEIGHT = 0.25, 1.7  # [m] radius and height of a person


@dataclass(frozen=True, kw_only=True)
class Crowd(Family):
    """A hall in which people walk; the robot drives from one end to the other, without a map.

    The parameter `motion` is `social_force` (people avoid each other, walls and, if `polite`, the robot), `polynomial`
    (people avoid nothing, as in DynaBARN) or `mixed` (people of both kinds).

    Difficulty: number of `people`; `density`: people per floor area [1/m2]; preferred walking `speed` [m/s]; `length`
    of the shortest path without people [m].
    """

    people: Count = 8
    motion: str = "mixed"
    polite: Count = 1
    speed: PositiveMetresPerSecond = 0.8
    long: PositiveMetres = 12.0
    wide: PositiveMetres = 7.0

    def __post_init__(self) -> None:
        if self.motion not in ("social_force", "polynomial", "mixed"):
            raise InputError(f"motion must be social_force, polynomial or mixed, found '{self.motion}'.")

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        rng = self.rng(index)
        ground = Ground((-0.5, -0.5), (self.long + 0.5, self.wide + 0.5), [*self.hall(rng)])
        start, goal = (
            (1.0, float(rng.uniform(1.2, self.wide - 1.2))),
            (self.long - 1.0, float(rng.uniform(1.2, self.wide - 1.2))),
        )
        walks = [self.walk(rng, ground, i, start) for i in range(self.people)]
        ground.actors += [Post(str(w["name"]), float(x), float(y), RADIUS, HEIGHT) for w, (x, y) in walks]
        path = ground.grid(0.1).shortest(start, goal, 0.32)
        if path is None:
            raise InputError(f"a hall of {self.long} x {self.wide} m is too small.")
        name, doc = self.scene_name(index), f"Through a hall in which {self.people} people walk about."
        scenario = goal_scenario(self, name, doc, Pose2(*start, 0.0), goal, tolerance=0.5, duration=90.0)
        scenario |= {"actor": [walk for walk, _ in walks]}
        difficulty = {
            "people": float(self.people),
            "density": self.people / (self.long * self.wide),
            "speed": self.speed,
            "length": path.length,
        }
        return Scene(scenario, ground, difficulty, path.points)

    def hall(self, rng: np.random.Generator) -> list[Block | Post]:
        """Four walls and a few pillars."""
        obstacles = walls_around((0.0, 0.0), (self.long, self.wide))
        for i in range(3):
            x, y = rng.uniform((3.0, 1.5), (self.long - 3.0, self.wide - 1.5)).tolist()
            obstacles.append(Post(f"pillar_{i}", x, y, 0.2, 2.0))
        return obstacles

    def walk(
        self, rng: np.random.Generator, ground: Ground, index: int, start: tuple[float, float]
    ) -> tuple[dict[str, object], tuple[float, float]]:
        """Sample a person's walk across the hall, away from robot and pillars: actor table and start position [m]."""
        pillars = [(obstacle.x, obstacle.y) for obstacle in ground.obstacles if isinstance(obstacle, Post)]
        script = self.motion if self.motion != "mixed" else ("social_force", "polynomial")[index % 2]
        while True:
            x, y, to_x, to_y = rng.uniform((2.8, 1.0) * 2, (self.long - 1.0, self.wide - 1.0) * 2).tolist()
            # A polynomial walk avoids nothing, so its whole line must be free; others need only a free start.
            kept = (x, y, to_x, to_y) if script == "polynomial" else (x, y, x, y)
            if dist((x, y), (to_x, to_y)) > 3.0 and dist((x, y), start) > 1.5 and line_clearance(kept, pillars) > 1.1:
                break
        table: dict[str, object] = {
            "name": f"P{index}",
            "script": script,
            **position((x, y)),
            "to_x": quantity(to_x, "m"),
            "to_y": quantity(to_y, "m"),
            "speed": quantity(self.speed * float(rng.uniform(0.7, 1.3)), "m/s"),
        }
        own = (
            {"radius": quantity(RADIUS, "m"), "avoids_robots": self.polite}
            if script == "social_force"
            else {"deviation": "0.6 m"}
        )
        return {**table, **own}, (x, y)


def line_clearance(line: tuple[float, float, float, float], points: list[tuple[float, float]]) -> float:
    """Minimum distance between a straight line and some points [m]."""
    along = np.linspace(line[:2], line[2:], 30)
    return float(np.min([np.hypot(*(along - point).T) for point in points]))
