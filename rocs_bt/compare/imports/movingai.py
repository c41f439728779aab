"""MovingAI: grid maps and problems from a user's copy of Sturtevant's benchmarks.

Sources: Sturtevant, Benchmarks for Grid-Based Pathfinding, IEEE Transactions on Computational Intelligence and AI in
Games 4 (2012), and the format description on its page. The columns of a .scen file are: bucket, map, width, height,
start x, start y, goal x, goal y, optimal length; x points right and y down from the upper left cell.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...errors import Fault, InputError
from ...files import read_text
from ..family import AgentSetup, Scene
from ..floor_grid import FloorGrid
from ..ground import Ground
from .map_scenes import RADIUS, ground_of, scene_between
from .raster import MOST_CELLS

_FREE, _TAKEN = ".GS", "@OTW"  # ground, grass, swamp; out of bounds, trees, water
_COLUMNS = 9


def read_movingai(
    folder: Path, setup: AgentSetup | None = None, *, cell: float = 0.5, every: int = 100
) -> Iterator[Scene]:
    """Yield the scenes of each .scen file in a folder and its subfolders, except those too narrow for the robot.

    Args:
        folder: Folder of .map and .scen files, or one .scen file.
        setup: Robot, mission and rules; the Jackal by default.
        cell: Side of a cell [m].
        every: Stride n: only every n-th problem of a file is read.

    Raises:
        InputError: There is no .scen file, or a file is invalid; with the line.
    """
    files = [folder] if folder.suffix == ".scen" else sorted(folder.rglob("*.scen"))
    if not files:
        raise InputError(
            Fault("the folder has no .scen file.", folder, hint="Give the folder of the .map and .scen files.")
        )
    for file in files:
        yield from _scenes(file, setup or AgentSetup(), cell, every)


def read_movingai_map(file: Path, cell: float) -> FloorGrid:
    """Read a .map file as an occupancy grid.

    Args:
        file: The .map file.
        cell: Side of a cell [m].

    Raises:
        InputError: The file is not a map; with the line.
    """
    lines = _lines(file)
    head = {words[0]: words[1] for line in lines[:4] if len(words := line.split()) == 2}
    sizes = [head.get(key, "") for key in ("height", "width")]
    if not lines or not lines[0].startswith("type") or "map" not in [line.strip() for line in lines[:5]]:
        raise InputError(Fault("a map begins with: type, height, width, map.", file, 1))
    if not all(size.isdecimal() and int(size[:8]) > 0 for size in sizes):
        raise InputError(Fault(f"height and width must be positive integers, found {sizes}.", file, 2))
    height, width = (int(size[:8]) for size in sizes)
    begin = [line.strip() for line in lines].index("map") + 1
    rows = lines[begin : begin + height]
    if height * width > MOST_CELLS or len(rows) != height:
        raise InputError(Fault(f"the map has {len(rows)} rows, not {height}.", file, begin))
    for number, row in enumerate(rows, begin + 1):
        if len(row) != width or (odd := set(row) - set(_FREE + _TAKEN)):
            found = f"{len(row)} cells, not {width}" if len(row) != width else f"unknown cells: {sorted(odd)}"
            raise InputError(Fault(f"this row has {found}.", file, number))
    occupied = np.array([[c in _TAKEN for c in row] for row in reversed(rows)], dtype=np.bool_)
    return FloorGrid(occupied, cell, (0.0, 0.0))


@dataclass(frozen=True)
class _Problem:
    """One row of a .scen file; start and goal are (column, row) from the upper left, lengths are in cells."""

    map: str
    start: tuple[int, int]
    goal: tuple[int, int]
    optimal: float


def _scenes(file: Path, setup: AgentSetup, cell: float, every: int) -> Iterator[Scene]:
    maps: dict[str, tuple[FloorGrid, FloorGrid, Ground]] = {}
    for number, line in list(enumerate(_lines(file)))[1 :: max(every, 1)]:
        if not line.strip():
            continue
        problem = _problem(line, file, number + 1)
        map_file = file.parent / problem.map
        if problem.map not in maps:
            grid = read_movingai_map(map_file, cell)
            maps[problem.map] = grid, _finer(grid), ground_of(grid, map_file)
        grid, fine, ground = maps[problem.map]
        height, width = grid.occupied.shape
        if not all(0 <= x < width and 0 <= y < height for x, y in (problem.start, problem.goal)):
            raise InputError(Fault(f"start or goal is outside the map of {width} x {height} cells.", file, number + 1))
        start, goal = (grid.centre(height - 1 - y, x) for x, y in (problem.start, problem.goal))
        clearances = fine.clearances()
        if start == goal or min(clearances[fine.cell_at(end)] for end in (start, goal)) <= RADIUS:
            continue
        if (path := fine.shortest(start, goal, RADIUS)) is None:
            continue
        name = f"movingai_{map_file.stem}-{number - 1}"
        doc = f"Problem {number - 1} on MovingAI's map {map_file.stem}, without a map."
        yield scene_between(name, doc, ground, start, goal, path, setup, optimal=problem.optimal * cell)


def _problem(line: str, file: Path, number: int) -> _Problem:
    words = line.split()
    if len(words) != _COLUMNS:
        raise InputError(Fault(f"a problem has {_COLUMNS} columns, found {len(words)}.", file, number))
    try:
        x0, y0, x1, y1 = (int(word) for word in words[4:8])
        optimal = float(words[8])
    except ValueError:
        message = "start and goal must be integers, and the length a number."
        raise InputError(Fault(message, file, number)) from None
    if not 0.0 <= optimal < 1e9:
        raise InputError(Fault(f"the optimal length must be a number, found {words[8]}.", file, number))
    return _Problem(Path(words[1]).name, (x0, y0), (x1, y1), optimal)


def _finer(grid: FloorGrid) -> FloorGrid:
    """The same grid with cells of at most 0.1 m, to resolve the robot's radius."""
    times = max(1, min(round(grid.cell / 0.1), int((MOST_CELLS / grid.occupied.size) ** 0.5)))
    return FloorGrid(np.kron(grid.occupied, np.ones((times, times), dtype=np.bool_)), grid.cell / times, grid.low)


def _lines(file: Path) -> list[str]:
    return read_text(file).splitlines()
