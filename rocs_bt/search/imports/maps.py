"""Maps of ROS's map server as worlds of walls: occupied cells are walls, unknown ones are empty.

A map has no starts and goals. These are sampled with a seed from the map's name, so every import gives the same scenes;
the path between them leads over free cells only.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

import numpy as np

from ...base.errors import Fault, InputError
from ...base.files import read_text
from ...base.geometry import Pose2
from ...compare.family import AgentSetup, Scene, goal_scenario, quantity
from ...compare.floor_grid import FloorGrid, GridPath
from ...compare.ground import Ground
from ...compare.obstacle import Point
from .raster import read_map

APART = 4.0
"""Minimum distance between start and goal [m]; on a small map, 0.6 times the diagonal of its free cells."""

RADIUS = 0.32
"""Radius of a disc for which every scene must have a path [m]; a Jackal turns within a radius of 0.33 m."""

MOST_BLOCKS = 5000
"""Maximum number of boxes in a world; with more, the simulation of a laser scan would take seconds."""


_ENDS = (".yaml", ".yml")
_SAMPLES = 1000


def read_maps(path: Path, setup: AgentSetup | None = None, *, pairs: int = 5) -> Iterator[Scene]:
    """Yield `pairs` scenes on each map of a YAML file, or of a folder and its subfolders: `map_<name>-0` ...

    Raises:
        InputError: There is no map, a map is invalid, or it has no room for a scene; with the file.
    """
    found = sorted(file for end in _ENDS for file in path.rglob(f"*{end}"))
    files = [path] if path.suffix in _ENDS else [file for file in found if "image:" in _text(file)]
    if not files:
        hint = "Give a map's .yaml file, or a folder that has one, with its .pgm or .png beside it."
        raise InputError(Fault("there is no map: no .yaml file names an image.", path, hint=hint))
    for file in files:
        made = read_map(file)
        ground = _ground(made.walls, file)
        seed = hashlib.sha256(file.stem.encode()).digest()
        rng = np.random.default_rng(np.random.SeedSequence(int.from_bytes(seed, "big")))
        pair = -1
        for pair, ends in enumerate(islice(_pairs(made.barred, rng), pairs)):
            yield _scene(f"map_{file.stem}-{pair}", f"Map {file.stem}.", ground, *ends, setup or AgentSetup())
        if pair < 0:
            hint = f"A robot needs {2.0 * RADIUS:g} m of width; look at free_thresh, resolution and negate."
            raise InputError(Fault("the map has no start and goal with a path of free cells.", file, hint=hint))


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


def _pairs(grid: FloorGrid, rng: np.random.Generator) -> Iterator[tuple[Point, Point, GridPath]]:
    """Sample starts and goals that are apart, in one free area, each with its path; ends if samples fail for long."""
    from scipy.ndimage import label

    clearances = grid.clearances()
    areas, _ = label(clearances > RADIUS + grid.cell)
    wide = clearances > 2.0 * RADIUS  # at a start nearer to a wall, reflexes would hold the robot
    rows, columns = np.nonzero(np.where(wide, areas, 0) if wide.any() else areas)
    points = [grid.centre(int(row), int(column)) for row, column in zip(rows, columns, strict=True)]
    apart = min(APART, 0.6 * math.hypot(*(np.ptp(points, axis=0) if points else (0.0, 0.0))))
    tried = 0
    while tried < _SAMPLES and len(points) > 1:
        one, other = rng.integers(len(points), size=2).tolist()
        same = areas[rows[one], columns[one]] == areas[rows[other], columns[other]]
        tried += 1
        if same and math.dist(points[one], points[other]) >= max(apart, grid.cell):
            path = grid.shortest(points[one], points[other], RADIUS)
            if path is not None:
                tried = 0
                yield points[one], points[other], path


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
