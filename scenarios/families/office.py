"""Rooms with doorways and furniture on both sides of a corridor; the robot drives to another room, without a map."""

from math import dist, pi

import numpy as np

from rocs_bt import Count, InputError, Pose2, PositiveCount, PositiveMetres
from rocs_bt.compare import Block, Family, Floor, Post, Scene, goal_scenario

WALL = 0.1  # [m] thickness
ROOMY = 0.32  # [m] every scene has a path for a disc of this radius


class Office(Family):
    """Rooms with doorways and furniture on both sides of a corridor; the robot drives to another room, without a map.

    Difficulty: `length` of the shortest path [m]; minimum `clearance` along this path [m]; `detour`: length of this
    path divided by that of the straight line; `things`: number of obstacles, walls included; `doorway`: width of the
    narrower of the doorways of start and goal room [m].
    """

    rooms: PositiveCount = 4
    depth: PositiveMetres = 3.6
    width: PositiveMetres = 3.2
    corridor: PositiveMetres = 1.8
    furniture: Count = 4

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        for attempt in range(200):
            rng = self.rng(index, f"attempt {attempt}")
            floor, doors = self.walls(rng)
            side, other = rng.permutation(2 * self.rooms)[:2].tolist()
            start, goal = self.middle(side), self.middle(other)
            self.furnish(floor, rng, (start, goal))
            if (path := floor.grid(0.05).shortest(start, goal, ROOMY)) is not None:
                break
        else:
            raise InputError(f"no sampled office of these sizes has a path for a robot of radius {ROOMY} m.")
        name, doc = self.scene_name(index), "From one room of an office to another, without a map."
        heading = pi / 2.0 if start[1] < 0.0 else -pi / 2.0
        scenario = goal_scenario(self, name, doc, Pose2(*start, heading), goal, tolerance=0.5, duration=90.0)
        difficulty = {
            "length": path.length,
            "clearance": path.clearance,
            "detour": path.length / dist(start, goal),
            "things": float(len(floor.obstacles)),
            "doorway": min(doors[side], doors[other]),
        }
        return Scene(scenario, floor, difficulty, path.points)

    def walls(self, rng: np.random.Generator) -> tuple[Floor, list[float]]:
        """Sample the walls: an office without furniture, and the width of each room's doorway [m], south side first."""
        long, high = self.rooms * self.width, 0.5 * self.corridor + self.depth
        floor = Floor((-0.5, -high - 0.5), (long + 0.5, high + 0.5))
        doors = []
        for row, sign in enumerate((-1.0, 1.0)):
            near, far = sign * 0.5 * self.corridor, sign * high
            floor.obstacles.append(Block(f"outer{row}", long / 2.0, far, long + WALL, WALL))
            for i in range(self.rooms + 1):
                y, length = (0.5 * (near + far), self.depth) if 0 < i < self.rooms else (far / 2.0, high)
                floor.obstacles.append(Block(f"between{row}_{i}", i * self.width, y, WALL, length))
            for i in range(self.rooms):
                opening = float(rng.uniform(0.9, 1.3))
                first = i * self.width + float(rng.uniform(0.3, self.width - opening - 0.3))
                doors.append(opening)
                for part, (a, b) in enumerate(((i * self.width, first), (first + opening, (i + 1) * self.width))):
                    floor.obstacles.append(Block(f"door{row}_{i}_{part}", 0.5 * (a + b), near, b - a, WALL))
        return floor, doors

    def middle(self, room: int) -> tuple[float, float]:
        """Centre of a room [m]."""
        row, i = divmod(room, self.rooms)
        return (i + 0.5) * self.width, (-1.0, 1.0)[row] * 0.5 * (self.corridor + self.depth)

    def furnish(self, floor: Floor, rng: np.random.Generator, free: tuple[tuple[float, float], ...]) -> None:
        """Add desks and posts to the rooms, and some to the corridor, away from positions that must be free."""
        for room in range(2 * self.rooms):
            x0, y0 = self.middle(room)
            for i in range(self.furniture):
                x = x0 + float(rng.uniform(-0.5, 0.5)) * (self.width - 0.8)
                y = y0 + float(rng.uniform(-0.5, 0.5)) * (self.depth - 0.8)
                self.add(floor, rng, f"thing{room}_{i}", x, y, free)
        for i in range(self.rooms // 2):
            x = float(rng.uniform(0.5, self.rooms * self.width - 0.5))
            y = float(rng.choice([-1.0, 1.0])) * (0.5 * self.corridor - 0.3)
            self.add(floor, rng, f"corridor_{i}", x, y, free)

    def add(
        self,
        floor: Floor,
        rng: np.random.Generator,
        name: str,
        x: float,
        y: float,
        free: tuple[tuple[float, float], ...],
    ) -> None:
        """Add one piece of furniture, unless it is too near to a position that must be free."""
        if any(dist((x, y), point) < 1.1 for point in free):
            return
        if rng.random() < 0.5:
            floor.obstacles.append(Post(name, x, y, float(rng.uniform(0.05, 0.25))))
        else:
            length, width = (float(v) for v in rng.uniform((0.3, 0.3), (1.2, 0.7)))
            floor.obstacles.append(Block(name, x, y, length, width, float(rng.uniform(0.0, pi))))
