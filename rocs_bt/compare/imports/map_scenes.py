"""Scenes on a grid map, with a sampled or given start and goal and a path between them."""

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
"""Radius of a disc for which every scene must have a path [m]; a Jackal turns within a radius of 0.33 m."""

MOST_BLOCKS = 5000
"""Maximum number of boxes in a world; with more, the simulation of a laser scan would take seconds."""


def ground_of(grid: FloorGrid, file: Path) -> Ground:
    """Convert a map to a ground with boxes for the occupied cells.

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
    """Sample a free start and goal at least `apart` [m] from each other, with a path; None if 60 samples fail."""
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
    """Scene in which a robot drives from a start to a goal [m]; at the start it faces along the path."""
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
        agent={"success": {"goal": "goal", "shortest_path": quantity(path.length, "m")}},
    )
    measured = {"length": path.length, "clearance": path.clearance, "detour": path.length / math.dist(start, goal)}
    return Scene(scenario, ground, {**measured, **difficulty}, path.points)
