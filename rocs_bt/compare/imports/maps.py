"""Maps of ROS's map server as worlds of walls.

A map has no starts and goals. These are sampled with a seed from the map's name, so every import gives the same scenes.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ...errors import Fault, InputError
from ...files import read_text
from ...geometry import Pose2
from ..family import AgentSetup, Scene, goal_scenario, quantity
from ..floor_grid import FloorGrid, GridPath
from ..ground import Ground
from ..obstacle import Point
from .raster import read_map

APART = 4.0
"""Minimum distance between start and goal [m]."""

RADIUS = 0.32
"""Radius of a disc for which every scene must have a path [m]; a Jackal turns within a radius of 0.33 m."""

MOST_BLOCKS = 5000
"""Maximum number of boxes in a world; with more, the simulation of a laser scan would take seconds."""


def read_maps(path: Path, setup: AgentSetup | None = None, *, pairs: int = 5) -> Iterator[Scene]:
    """Yield scenes on each map: `map_<name>-0`, `map_<name>-1` ...

    Args:
        path: A map's YAML file, or a folder with maps in it and its subfolders.
        setup: Robot, mission and rules; the Jackal by default.
        pairs: Number of start-goal pairs per map.

    Raises:
        InputError: There is no map, a map is invalid, or it has no room for a scene; with the file.
    """
    files = [path] if path.suffix == ".yaml" else sorted(f for f in path.rglob("*.yaml") if "image:" in _text(f))
    if not files:
        hint = "Give a map's .yaml file, or a folder that has one, with its .pgm or .png beside it."
        raise InputError(Fault("the folder has no map: no .yaml file names an image.", path, hint=hint))
    for file in files:
        grid = read_map(file)
        ground = _ground(grid, file)
        seed = hashlib.sha256(file.stem.encode()).digest()
        rng = np.random.default_rng(np.random.SeedSequence(int.from_bytes(seed, "big")))
        for pair in range(pairs):
            ends = _sample_ends(grid, rng)
            if ends is None:
                raise InputError(Fault(f"found no start and goal {APART:g} m apart with a path between them.", file))
            yield _scene(f"map_{file.stem}-{pair}", f"Map {file.stem}.", ground, *ends, setup or AgentSetup())


def _text(file: Path) -> str:
    try:
        return read_text(file)
    except InputError:
        return ""


def _ground(grid: FloorGrid, file: Path) -> Ground:
    """Ground with boxes for the occupied cells of a map."""
    rows, columns = grid.occupied.shape
    low, high = grid.low, (grid.low[0] + columns * grid.cell, grid.low[1] + rows * grid.cell)
    blocks = grid.blocks()
    if len(blocks) > MOST_BLOCKS:
        message = f"the map needs {len(blocks)} boxes; a world may have at most {MOST_BLOCKS}."
        raise InputError(Fault(message, file, hint="Use a smaller or coarser map."))
    return Ground(low, high, blocks)


def _sample_ends(grid: FloorGrid, rng: np.random.Generator) -> tuple[Point, Point, GridPath] | None:
    """Sample a free start and goal that are apart, with a path between them; None if 60 samples fail."""
    rows, columns = np.nonzero(grid.clearances() > RADIUS + grid.cell)
    for _ in range(60 if len(rows) > 1 else 0):
        one, other = rng.integers(len(rows), size=2).tolist()
        start, goal = grid.centre(int(rows[one]), int(columns[one])), grid.centre(int(rows[other]), int(columns[other]))
        if math.dist(start, goal) >= APART and (path := grid.shortest(start, goal, RADIUS)) is not None:
            return start, goal, path
    return None


def _scene(name: str, doc: str, ground: Ground, start: Point, goal: Point, path: GridPath, setup: AgentSetup) -> Scene:
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
    return Scene(scenario, ground, measured, path.points)
