"""Field of cylinders like those of BARN; the robot drives through it to a goal behind it, without a map.

This is an independent generator, based on the published description of the BARN dataset (Perille, Truong, Xiao and
Stone, Benchmarking Metric Ground Navigation, SSRR 2020) and on the sizes in BARN's published generator. A cellular
automaton on 30 x 30 cells of 0.15 m starts with 15 to 30 % occupied cells and makes two to four smoothing steps. Each
occupied cell that is not fully enclosed becomes a cylinder of 0.15 m diameter. A field must have a path for a robot of
5 x 5 cells, and is sampled again otherwise. Corridor, start, goal and time limit are those of the BARN challenge. No
parameter was tuned to match the measures of BARN's 300 worlds.
"""

from math import dist, pi

import numpy as np
import numpy.typing as npt

from rocs_bt import Pose2
from rocs_bt.compare import Family, Floor, Post, Scene, goal_scenario, length_of, shortest_cells

Field = npt.NDArray[np.bool_]
Point = tuple[float, float]

CELLS, CELL, RADIUS = 30, 0.15, 0.075  # [m]
START, GOAL = Pose2(-2.25, 3.0, pi / 2.0), (-2.25, 13.0)
FILLS, SMOOTHINGS = (0.15, 0.2, 0.25, 0.3), (2, 3, 4)
ROBOT = 2  # number of cells that the robot covers on either side of the cell of its centre
SHY = 0.15  # [m] extra cost of a step to a cell next to one where the robot does not fit; half of it two cells away


class BarnLike(Family):
    """A field of cylinders like those of BARN; the robot drives through it to a goal behind it, without a map.

    As in BARN, the reference path enters and leaves the field at random cells of its near and far edge.

    Difficulty: number of `cylinders` in the field; `length` of the reference path [m]; minimum `clearance` along this
    path [m]; `detour`: length of this path divided by that of the straight line.
    """

    def scene(self, index: int) -> Scene:
        """Generate the scene with an index."""
        rng = self.rng(index)
        fill, smoothings, path = rng.choice(FILLS), rng.choice(SMOOTHINGS), None
        while path is None:
            field = automaton(rng, fill, smoothings)
            path = reference(field, rng)
        standing = [
            Post(f"p{r}_{c}", *centre(r, c), RADIUS)
            for r, c in np.argwhere(field & (neighbours(field, False) < 8)).tolist()
        ]
        posts = [*corridor(), *standing]
        floor = Floor((-6.5, -1.0), (2.0, 15.0), list(posts))
        length = length_of(path)
        difficulty = {
            "cylinders": float(sum(post.y > 5.0 for post in posts)),
            "length": length,
            "clearance": floor.clearance(path),
            "detour": length / dist(path[0], path[-1]),
        }
        name = self.scene_name(index)
        doc = f"Through a field of {difficulty['cylinders']:.0f} cylinders without a map, to a goal behind it."
        scenario = goal_scenario(self, name, doc, START, GOAL, tolerance=1.0, duration=100.0)
        return Scene(scenario, floor, difficulty, tuple(path))


def automaton(rng: np.random.Generator, fill: float, smoothings: int) -> Field:
    """Sample a field: whether each cell is occupied, shape (rows, columns); the two long sides are walls."""
    field = rng.random((CELLS, CELLS)) < fill
    field[:, [0, -1]] = True
    for _ in range(smoothings):
        around = neighbours(field, True)
        field = (field & (around > 1)) | (around > 4)
    return field


def neighbours(field: Field, beyond: bool) -> npt.NDArray[np.int_]:
    """Number of occupied cells among the eight neighbours of each cell, shape (rows, columns).

    Args:
        field: Whether each cell is occupied.
        beyond: Whether cells beyond the two long sides count as occupied.
    """
    padded = np.zeros((CELLS + 2, CELLS + 2), dtype=np.int_)
    padded[1:-1, 1:-1] = field
    padded[:, [0, -1]] = beyond
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    counts: npt.NDArray[np.int_] = rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:] - field
    return counts


def centre(row: int, column: int) -> Point:
    """Position of a cell in the world [m]."""
    return -4.425 + CELL * column, 5.175 + CELL * row


def corridor() -> list[Post]:
    """Cylinders around the start: two walls that lead to the field, and one behind the start."""
    sides = [Post(f"c{i}_{k}", x, 0.075 + CELL * k, RADIUS) for i, x in enumerate((-4.425, -0.075)) for k in range(34)]
    return sides + [Post(f"c2_{k}", -4.425 + CELL * k, 0.075, RADIUS) for k in range(1, 29)]


def reference(field: Field, rng: np.random.Generator) -> list[Point] | None:
    """Corners of a short path through the field that prefers some distance from cylinders [m]; None if there is none.

    The path enters and leaves the field at random cells of the near and far edge, both in the largest free region
    there.
    """
    from scipy import ndimage

    free = ~ndimage.binary_dilation(field, np.ones((2 * ROBOT + 1, 2 * ROBOT + 1)))
    if not free.any(axis=1).all():  # a cheap test that nearly always rejects the field
        return None
    regions, _ = ndimage.label(free)
    sizes = np.bincount(regions.ravel())
    into, out = (max(set(edge[edge > 0].tolist()), key=lambda i: sizes[i], default=0) for edge in regions[[0, -1]])
    if not into or into != out:
        return None
    ends = [(row, int(rng.choice(np.flatnonzero(regions[row] == into)))) for row in (0, CELLS - 1)]
    away = ndimage.distance_transform_cdt(np.pad(free, 1, constant_values=True), "chessboard")[1:-1, 1:-1]
    extra_cost = np.where(away <= 2, SHY / np.maximum(away, 1), 0.0)
    cells = shortest_cells(free, ends[0], ends[1], CELL, extra_cost)
    return None if cells is None else [(START.x, START.y), *(centre(r, c) for r, c in cells), GOAL]
