"""A maze with a few loops; the robot drives from one corner to the opposite one, without a map."""

from math import dist, pi

import numpy as np

from rocs_bt import Count, InputError, Pose2, PositiveCount, PositiveMetres
from rocs_bt.compare import Block, Family, Floor, Scene, goal_scenario, walls_around

WALL = 0.1  # [m] thickness
STEPS = ((0, 1), (1, 0), (0, -1), (-1, 0))


class Maze(Family):
    """A maze with a few loops; the robot drives from one corner to the opposite one, without a map.

    The passages are a random depth-first spanning tree of the cells; then as many more walls as the parameter `loops`
    says are removed.

    Difficulty: `length` of the shortest path [m]; minimum `clearance` along this path [m]; `detour`: length of this
    path divided by that of the straight line; number of `dead_ends`; number of `turns` on this path.
    """

    columns: PositiveCount = 6
    rows: PositiveCount = 5
    cell: PositiveMetres = 1.3
    loops: Count = 2

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        rng = self.rng(index)
        open_ = self.passages(rng)
        floor = self.floor(open_)
        start, goal = self.middle((0, 0)), self.middle((self.rows - 1, self.columns - 1))
        path = floor.grid(0.05).shortest(start, goal, 0.32)
        if path is None:
            raise InputError(f"cells of {self.cell} m are too narrow for a robot of radius 0.32 m.")
        name, doc = self.scene_name(index), f"A maze of {self.columns} x {self.rows} cells, without a map."
        heading = 0.0 if ((0, 0), (0, 1)) in open_ else pi / 2.0
        scenario = goal_scenario(self, name, doc, Pose2(*start, heading), goal, tolerance=0.4, duration=120.0)
        cells = [(r, c) for r in range(self.rows) for c in range(self.columns)]
        exits = [sum(((r, c), (r + a, c + b)) in open_ for a, b in STEPS) for r, c in cells]
        difficulty = {
            "length": path.length,
            "clearance": path.clearance,
            "detour": path.length / dist(start, goal),
            "dead_ends": float(exits.count(1)),
            "turns": float(len(path.points) - 2),
        }
        return Scene(scenario, floor, difficulty, path.points)

    def passages(self, rng: np.random.Generator) -> set[tuple[tuple[int, int], tuple[int, int]]]:
        """Sample the passages: ordered pairs of neighbouring cells (row, column) without a wall between them."""
        seen, walk, open_ = {(0, 0)}, [(0, 0)], set()

        def beside(cell: tuple[int, int]) -> list[tuple[int, int]]:
            around = ((cell[0] + a, cell[1] + b) for a, b in STEPS)
            return [(r, c) for r, c in around if 0 <= r < self.rows and 0 <= c < self.columns]

        while walk:
            new = [cell for cell in beside(walk[-1]) if cell not in seen]
            if not new:
                walk.pop()
                continue
            chosen = new[int(rng.integers(len(new)))]
            open_ |= {(walk[-1], chosen), (chosen, walk[-1])}
            seen.add(chosen)
            walk.append(chosen)
        shut = [(a, b) for a in sorted(seen) for b in beside(a) if a < b and (a, b) not in open_]
        for i in rng.permutation(len(shut))[: self.loops].tolist():
            a, b = shut[i]
            open_ |= {(a, b), (b, a)}
        return open_

    def floor(self, open_: set[tuple[tuple[int, int], tuple[int, int]]]) -> Floor:
        """Outer walls, and walls between cells without a passage."""
        wide, high = self.columns * self.cell, self.rows * self.cell
        obstacles = walls_around((0.0, 0.0), (wide, high))
        for r in range(self.rows):
            for c in range(self.columns):
                x, y = self.middle((r, c))
                if c + 1 < self.columns and ((r, c), (r, c + 1)) not in open_:
                    obstacles.append(Block(f"v{r}_{c}", x + self.cell / 2.0, y, WALL, self.cell + WALL))
                if r + 1 < self.rows and ((r, c), (r + 1, c)) not in open_:
                    obstacles.append(Block(f"h{r}_{c}", x, y + self.cell / 2.0, self.cell + WALL, WALL))
        return Floor((-0.5, -0.5), (wide + 0.5, high + 0.5), obstacles)

    def middle(self, cell: tuple[int, int]) -> tuple[float, float]:
        """Centre of a cell [m]."""
        return (cell[1] + 0.5) * self.cell, (cell[0] + 0.5) * self.cell
