"""Variations of EXP1: unknown boxes between the robot and its goal, and other robots that wander."""

from math import atan2, dist, pi

import numpy as np

from rocs_bt import Count, InputError, Pose2, PositiveMetres, PositiveMetresPerSecond
from rocs_bt.compare import Block, Family, Floor, Scene, goal_scenario, position, quantity, walls_around

RADIUS = 0.3  # [m] every scene has a path for a disc of this radius


class Exp1Family(Family):
    """Variations of EXP1: unknown boxes between the robot and its goal, and other robots that wander.

    These are scenes of the paper's first experiment with random start, goal, boxes and wandering robots (wanderers).
    The first box is near the straight line from start to goal.

    Difficulty: `length` of the shortest path [m]; minimum `clearance` along this path [m]; `detour`: length of this
    path divided by that of the straight line; number of `boxes`; number of `wanderers`.
    """

    robot: str = "pioneer_p3dx"
    boxes: Count = 2
    wanderers: Count = 1
    side: PositiveMetres = 5.0
    speed: PositiveMetresPerSecond = 0.3

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        for attempt in range(300):
            rng = self.rng(index, f"attempt {attempt}")
            half = self.side / 2.0
            start, goal = (tuple(rng.uniform(-half + 0.5, half - 0.5, 2).tolist()) for _ in range(2))
            if dist(start, goal) < 0.45 * self.side:
                continue
            floor = Floor(
                (-half, -half), (half, half), walls_around((-half, -half), (half, half), thickness=0.05, height=0.5)
            )
            others = self.place_objects(floor, rng, start, goal)
            path = floor.grid(0.05).shortest(start, goal, RADIUS)
            if others is not None and path is not None:
                break
        else:
            raise InputError(f"{self.boxes} boxes and {self.wanderers} wanderers do not fit into {self.side} m.")
        name, doc = self.scene_name(index), f"EXP1 with {self.boxes} unknown boxes, random start and goal."
        heading = atan2(goal[1] - start[1], goal[0] - start[0])
        pose = Pose2(start[0], start[1], heading)
        scenario = goal_scenario(self, name, doc, pose, (goal[0], goal[1]), tolerance=0.1, duration=60.0)
        scenario |= {
            "end_on_collision": False,
            "actor": [self.wanderer(i, point, rng) for i, point in enumerate(others)],
        }
        difficulty = {
            "length": path.length,
            "clearance": path.clearance,
            "detour": path.length / dist(start, goal),
            "boxes": float(self.boxes),
            "wanderers": float(self.wanderers),
        }
        return Scene(scenario, floor, difficulty, path.points)

    def place_objects(
        self, floor: Floor, rng: np.random.Generator, start: tuple[float, ...], goal: tuple[float, ...]
    ) -> list[tuple[float, float]] | None:
        """Add boxes to the floor and sample start positions of the wanderers [m]; None if they do not fit."""
        half, placed = self.side / 2.0, list[tuple[float, float]]()
        for i in range(self.boxes):
            if i == 0:  # near the straight line, like the box in the paper
                share, aside = rng.uniform(0.35, 0.65), rng.uniform(-0.2, 0.2, 2)
                x, y = (np.array(start) + share * (np.array(goal) - start) + aside).tolist()
            else:
                x, y = rng.uniform(-half + 0.5, half - 0.5, 2).tolist()
            if min(dist((x, y), start), dist((x, y), goal), *(dist((x, y), p) - 0.5 for p in placed), 9.0) < 0.75:
                return None
            placed.append((x, y))
            size = rng.uniform(0.3, 0.6, 2).tolist()
            floor.obstacles.append(Block(f"box_{i}", x, y, size[0], size[1], float(rng.uniform(0.0, pi / 2.0)), 0.5))
        others = [tuple(rng.uniform(-half + 0.6, half - 0.6, 2).tolist()) for _ in range(self.wanderers)]
        taken = [start, goal, *placed]
        for i, point in enumerate(others):
            if min(dist(point, other) for other in [*taken, *others[:i]]) < 0.8:
                return None
        return [(x, y) for x, y in others]

    def wanderer(self, index: int, point: tuple[float, float], rng: np.random.Generator) -> dict[str, object]:
        """Actor table of a robot that walks at random and yields to no other robot."""
        return {
            "name": f"W{index + 1}",
            "robot": "pioneer_p3dx",
            "script": "random_walk",
            **position(point, float(rng.uniform(-pi, pi))),
            "jitter": {"x": "0.1 m", "y": "0.1 m", "yaw": "180 deg"},
            "max_speed": quantity(self.speed, "m/s"),
        }
