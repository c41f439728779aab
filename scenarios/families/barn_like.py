"""A field of cylinders like BARN's: out of a corridor, through the field, to a goal behind it, without a map.

An own generator after the published description of the BARN dataset (Perille, Truong, Xiao and Stone, Benchmarking
Metric Ground Navigation, SSRR 2020): a cellular automaton on 30 x 30 cells of 0.15 m, initial fills of 15 to 30 %, two
to four smoothing steps, a cylinder of 0.15 m for each cell; the same corridor, start, goal and time limit as in the
challenge. The figures of the 300 published worlds that it is matched to: 87 to 271 cylinders in the field, median 166;
reference ways of 10.05 to 13.74 m, median 11.23; their clearance 0.181 to 0.975 m, median 0.225, 222 below 0.333 m.
"""

from dataclasses import dataclass
from math import dist, pi

import numpy as np
import numpy.typing as npt

from rocs_bt import Pose2
from rocs_bt.compare import Family, Ground, Post, Scene, clearance_of, goal_scenario, length_of, shortest_cells

Field = npt.NDArray[np.bool_]
Point = tuple[float, float]

CELLS, CELL, RADIUS = 30, 0.15, 0.075  # [m]
START, GOAL = Pose2(-2.25, 3.0, pi / 2.0), (-2.25, 13.0)
FILLS, SMOOTHINGS = (0.15, 0.2, 0.25, 0.3), (2, 3, 4)

# Shares of all worlds, with bounds of the cylinders in the field, and whether the reference way is wide: what three
# quantiles of two published figures leave of the automaton's worlds.
STRATA = ((0.13, 87, 150, True), (0.13, 150, 230, True), (0.24, 87, 166, False), (0.5, 166, 271, False))
LENGTHS, CLEARANCES, WIDE = (10.05, 13.74), (0.181, 0.975), 0.333  # [m]; wide is the circumscribed radius of a Jackal


@dataclass(frozen=True, kw_only=True)
class BarnLike(Family):
    """A field of cylinders like BARN's: out of a corridor, through the field, to a goal behind it, without a map.

    Difficulty: `cylinders` in the field, `length` of the reference way [m], `clearance` along it [m], `detour` over the
    straight way. The reference goes, as the published one does, through a random free cell of either edge of the field.
    """

    def scene(self, index: int) -> Scene:
        """The world of an index."""
        rng = self.rng(index)
        shares = np.cumsum([stratum[0] for stratum in STRATA])
        _, least, most, wide = STRATA[min(int(np.searchsorted(shares, rng.random())), len(STRATA) - 1)]
        while True:
            field = automaton(rng, rng.choice(FILLS), rng.choice(SMOOTHINGS))
            if not least <= field.sum() <= most or (way := reference(field, rng)) is None:
                continue
            posts = [*corridor(), *(Post(f"p{r}_{c}", *centre(r, c), RADIUS) for r, c in np.argwhere(field).tolist())]
            length, clearance = length_of(way), clearance_of(way, posts)
            fits = LENGTHS[0] <= length <= LENGTHS[1] and CLEARANCES[0] <= clearance <= CLEARANCES[1]
            if fits and (clearance >= WIDE) == wide:
                break
        name = self.scene_name(index)
        ground = Ground((-6.5, -1.0), (2.0, 15.0), list(posts))
        difficulty = {
            "cylinders": float(field.sum()),
            "length": length,
            "clearance": clearance,
            "detour": length / dist(way[0], way[-1]),
        }
        doc = f"Through a field of {int(field.sum())} cylinders without a map, to a goal behind it."
        text = goal_scenario(self, name, doc, START, GOAL, tolerance=1.0, duration=100.0)
        return Scene(name, text, ground.world(name, doc), difficulty, tuple(way), length, {"ground": ground})


def automaton(rng: np.random.Generator, fill: float, smoothings: int) -> Field:
    """(rows, columns) Where cylinders stand; the field's two long sides are walls."""
    field = rng.random((CELLS, CELLS)) < fill
    field[:, [0, -1]] = True
    for _ in range(smoothings):
        padded = np.pad(field, 1).astype(int)
        around = sum(
            padded[1 + r : 1 + r + CELLS, 1 + c : 1 + c + CELLS] for r in (-1, 0, 1) for c in (-1, 0, 1) if r or c
        )
        field = np.where(around >= 5, True, np.where(around <= 1, False, field))
        field[:, [0, -1]] = True
    return field


def centre(row: int, column: int) -> Point:
    """The place of a cell in the world [m]."""
    return -4.425 + CELL * column, 5.075 + CELL * row


def corridor() -> list[Post]:
    """The 94 cylinders around the start: two walls, and one behind it."""
    sides = [Post(f"c{i}_{k}", x, 0.075 + CELL * k, RADIUS) for i, x in enumerate((-4.425, -0.075)) for k in range(33)]
    return sides + [Post(f"c2_{k}", -4.425 + CELL * k, 0.075, RADIUS) for k in range(1, 29)]


def reference(field: Field, rng: np.random.Generator) -> list[Point] | None:
    """The corners of a shortest way over cells none of whose neighbours is taken; None where there is none.

    That leaves a disc of 0.225 m at each cell's centre. The way enters and leaves the field by random cells.
    """
    padded = np.pad(field, 1)
    near = np.zeros_like(field)
    for r in range(3):
        for c in range(3):
            near |= padded[r : r + CELLS, c : c + CELLS]
    entries, exits = np.flatnonzero(~near[0]), np.flatnonzero(~near[-1])
    if not len(entries) or not len(exits):
        return None
    ends = (0, int(rng.choice(entries))), (CELLS - 1, int(rng.choice(exits)))
    cells = shortest_cells(~near, *ends, CELL)
    return None if cells is None else [(START.x, START.y), *(centre(r, c) for r, c in cells), GOAL]
