"""Scenes on a grid map: sampled or given starts and goals, with a path between them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ...errors import Fault, InputError
from ...geometry import Pose2
from ..family import AgentSetup, Scene, goal_scenario, quantity
from ..floor_grid import FloorGrid, GridPath
from ..ground import Ground
from ..obstacle import Point

RADIUS = 0.32
"""Radius of the disc that has a path in every scene [m]; a Jackal turns within 0.33 m."""

MOST_BLOCKS = 5000
"""Maximum number of boxes in a world; more would cost seconds per scan."""


def ground_of(grid: FloorGrid, file: Path) -> Ground:
    """Ground of a map, with its occupied cells as boxes.

    Raises:
        InputError: The map needs too many boxes.
    """
    rows, columns = grid.occupied.shape
    low, high = grid.low, (grid.low[0] + columns * grid.cell, grid.low[1] + rows * grid.cell)
    blocks = grid.blocks()
    if len(blocks) > MOST_BLOCKS:
        raise InputError(
            Fault(
                f"the map needs {len(blocks)} boxes; a world may have at most {MOST_BLOCKS}.",
                file,
                hint="Use a smaller or coarser map.",
            )
        )
    return Ground(low, high, blocks)


def sample_ends(grid: FloorGrid, rng: np.random.Generator, apart: float) -> tuple[Point, Point, GridPath] | None:
    """Random free start and goal at a minimum distance [m], with the path between them; None after 60 attempts."""
    rows, columns = np.nonzero(grid.clearances() > RADIUS + grid.cell)
    for _ in range(60 if len(rows) > 1 else 0):
        one, other = rng.integers(len(rows), size=2).tolist()
        start, goal = grid.centre(int(rows[one]), int(columns[one])), grid.centre(int(rows[other]), int(columns[other]))
        if math.dist(start, goal) >= apart and (path := grid.shortest(start, goal, RADIUS)) is not None:
            return start, goal, path
    return None


def scene_between(
    name: str,
    doc: str,
    ground: Ground,
    start: Point,
    goal: Point,
    path: GridPath,
    setup: AgentSetup,
    **difficulty: float,
) -> Scene:
    """Scene from a start to a goal; the robot first faces along the path."""
    ahead = path.points[1]
    heading = math.atan2(ahead[1] - start[1], ahead[0] - start[0])
    duration = max(60.0, 10.0 * round(path.length))  # ten times the travel time at 1 m/s
    scenario = goal_scenario(
        setup,
        name,
        doc,
        Pose2(*start, heading),
        goal,
        tolerance=0.4,
        duration=min(duration, 3600.0),
        agent={"success": {"goal": "goal", "shortest": quantity(path.length, "m")}},
    )
    measured = {"length": path.length, "clearance": path.clearance, "detour": path.length / math.dist(start, goal)}
    return Scene(scenario, ground, {**measured, **difficulty}, path.points)
