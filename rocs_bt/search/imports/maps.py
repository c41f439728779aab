"""Maps of ROS's map server as worlds of walls: occupied cells are walls, unknown ones are empty.

A map has no starts and goals. These are sampled with a seed from the map's name, so every import gives the same scenes;
the path between them leads over free cells only.
"""

from __future__ import annotations

import hashlib
import math
import re
import struct
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from io import BytesIO
from itertools import islice
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ...base.errors import Fault, InputError
from ...base.files import read_bytes, read_text
from ...base.geometry import Pose2
from ...compare.family import AgentSetup, Scene, goal_scenario, quantity
from ...compare.floor import Floor
from ...compare.floor_grid import FloorGrid, GridPath
from ...compare.obstacle import Point

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
        floor = _floor(made.walls, file)
        seed = hashlib.sha256(file.stem.encode()).digest()
        rng = np.random.default_rng(np.random.SeedSequence(int.from_bytes(seed, "big")))
        pair = -1
        for pair, ends in enumerate(islice(_pairs(made.barred, rng), pairs)):
            yield _scene(f"map_{file.stem}-{pair}", f"Map {file.stem}.", floor, *ends, setup or AgentSetup())
        if pair < 0:
            hint = f"A robot needs {2.0 * RADIUS:g} m of width; look at free_thresh, resolution and negate."
            raise InputError(Fault("the map has no start and goal with a path of free cells.", file, hint=hint))


def _text(file: Path) -> str:
    try:
        return read_text(file)
    except InputError:
        return ""


def _floor(grid: FloorGrid, file: Path) -> Floor:
    """Floor with boxes for the occupied cells of a map."""
    rows, columns = grid.occupied.shape
    low, high = grid.low, (grid.low[0] + columns * grid.cell, grid.low[1] + rows * grid.cell)
    blocks = grid.blocks()
    if len(blocks) > MOST_BLOCKS:
        message = f"the map needs {len(blocks)} boxes; a world may have at most {MOST_BLOCKS}."
        raise InputError(Fault(message, file, hint="Use a smaller or coarser map."))
    return Floor(low, high, blocks)


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


def _scene(name: str, doc: str, floor: Floor, start: Point, goal: Point, path: GridPath, setup: AgentSetup) -> Scene:
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
    return Scene(scenario, floor, measured, path.points)


MOST_CELLS = 25_000_000
"""Maximum number of cells of a map; enough for a hectare with cells of 2 cm."""

_GAP = rb"(?:\s|#[^\n]*\n)+"
_HEADER = re.compile(rb"(P[25])" + _GAP + rb"(\d{1,7})" + _GAP + rb"(\d{1,7})" + _GAP + rb"(\d{1,5})\s")
_PNG, _SIZE = b"\x89PNG\r\n\x1a\n", struct.Struct(">II")
_NEEDED = ("image", "resolution", "origin")
_MODES = ("trinary", "scale")  # in both, the thresholds decide what is occupied and what is free
_UNKNOWN = 205  # shade of unknown cells in each saved map; that of Nav2 before 2025 says a free_thresh above it


@dataclass(frozen=True)
class MapFile:
    """Content of a map's YAML file.

    Attributes:
        image: Image file in the same folder.
        resolution: Side of a cell [m].
        origin: Position of the image's lower left corner [m].
        occupied: Darkness above which a cell is occupied, 0 to 1.
        free: Darkness below which a cell is free, 0 to 1. Between the two, the cell is unknown.
        negate: Whether white means occupied.
    """

    image: Path
    resolution: float
    origin: tuple[float, float]
    occupied: float
    free: float
    negate: bool


@dataclass(frozen=True)
class RosMap:
    """A map of ROS: what is occupied, and where a robot may be sent."""

    walls: FloorGrid
    barred: FloorGrid  # occupied or unknown cells


def read_map(file: Path) -> RosMap:
    """Read a map, a YAML file and its image, as map_server of ROS does.

    Raises:
        InputError: One of the two files is invalid; with the line if known.
    """
    settings = read_map_yaml(file)
    data = _image_bytes(settings.image)
    image = (read_png if data.startswith(_PNG) else read_pgm)(data, settings.image)[::-1]
    dark = image / 255.0 if settings.negate else 1.0 - image / 255.0
    free = dark < settings.free
    if not settings.negate:
        free &= image != _UNKNOWN
    place = settings.resolution, settings.origin
    return RosMap(FloorGrid(dark > settings.occupied, *place), FloorGrid(~free | (dark > settings.occupied), *place))


def read_map_yaml(file: Path) -> MapFile:
    """Read a map's YAML file: `key: value` in a line, or a list in the following ones. Map files have no other forms.

    Raises:
        InputError: The file is invalid; with the line.
    """
    found = _settings(read_text(file))
    if missing := [key for key in _NEEDED if key not in found]:
        raise InputError(
            Fault(f"the map lacks {', '.join(missing)}.", file, hint="See the file format of ROS's map server.")
        )
    name, line = found["image"]
    image = file.parent / name
    if not name or "\0" in name or image.resolve().parent != file.parent.resolve():
        hint = "Copy the image there, and write its name."
        raise InputError(Fault(f"the image must be a file beside the map, found '{name}'.", file, line, hint=hint))
    mode, line = found.get("mode", ("trinary", 0))
    if mode not in _MODES:
        hint = "Modes: " + ", ".join(_MODES) + "."
        raise InputError(Fault(f"maps of the mode '{mode}' are not supported.", file, line, hint=hint))
    occupied = _number(file, found, "occupied_thresh", 0.65, 0.0, 1.0)
    free = _number(file, found, "free_thresh", min(0.196, occupied), 0.0, 1.0)
    if free > occupied:
        line = found.get("free_thresh", found.get("occupied_thresh", ("", 0)))[1]
        message = f"free_thresh is {free:g} and occupied_thresh is {occupied:g}; it must not be larger."
        raise InputError(Fault(message, file, line))
    return MapFile(
        image,
        _number(file, found, "resolution", 0.1, 1e-3, 10.0),
        _origin(file, *found["origin"]),
        occupied,
        free,
        _number(file, found, "negate", 0.0, 0.0, 1.0) > 0.5,
    )


def _settings(text: str) -> dict[str, tuple[str, int]]:
    """Text and line of each key; a list over several lines is joined by commas."""
    found: dict[str, tuple[list[str], int]] = {}
    key = ""
    for line, content in enumerate(text.splitlines(), 1):
        words = re.sub(r"(^|\s)#.*", "", content).strip()
        if match := re.fullmatch(r"([A-Za-z_]+)\s*:(?:\s+(.*))?", words):
            key = match[1]
            found[key] = [(match[2] or "").strip("'\"")], line
        elif key and words:
            found[key][0].append(words.removeprefix("- "))
    return {key: (",".join(filter(None, parts)), line) for key, (parts, line) in found.items()}


def _number(
    file: Path, found: Mapping[str, tuple[str, int]], key: str, default: float, low: float, high: float
) -> float:
    words, line = found.get(key, (str(default), 0))
    try:
        value = float({"true": "1", "false": "0"}.get(words.lower(), words))
    except ValueError:
        value = math.nan
    if not low <= value <= high:
        raise InputError(Fault(f"{key} must be a number from {low:g} to {high:g}, found '{words}'.", file, line))
    return value


def _origin(file: Path, words: str, line: int) -> tuple[float, float]:
    try:
        origin = [float(word) for word in words.strip("[] ").split(",") if word.strip()]
    except ValueError:
        origin = []
    if len(origin) not in (2, 3) or not all(abs(value) < 1e5 for value in origin):
        raise InputError(Fault(f"origin must be [x, y, yaw], found '{words}'.", file, line))
    if len(origin) == 3 and abs(origin[2]) > 1e-6:
        raise InputError(Fault(f"rotated maps are not supported, found a yaw of {origin[2]} rad.", file, line))
    return origin[0], origin[1]


def read_pgm(data: bytes, file: Path) -> npt.NDArray[np.float64]:
    """Shades in a portable graymap (P2 or P5), 0 to 255, top row first, shape (rows, columns).

    Raises:
        InputError: The data of the file are not a graymap.
    """
    header = _HEADER.match(data)
    if header is None:
        raise InputError(
            Fault("the image is neither a PNG nor a portable graymap (P2 or P5).", file, hint="Convert it.")
        )
    columns, rows, most = (int(header[i]) for i in (2, 3, 4))
    if not (0 < columns * rows <= MOST_CELLS and 0 < most <= 65535):
        raise InputError(Fault(f"cannot import a map of {columns} x {rows} cells with {most} shades.", file))
    body = data[header.end() :]
    if header[1] == b"P5":
        kind = np.dtype(">u2" if most > 255 else "u1")
        whole = body[: len(body) - len(body) % kind.itemsize]
        shades = np.frombuffer(whole, dtype=kind)[: rows * columns].astype(np.float64)
    else:
        shades = _words(body, rows * columns)
    if len(shades) != rows * columns:
        raise InputError(Fault(f"the image ends before its {rows * columns} cells do.", file))
    return shades.reshape(rows, columns) * (255.0 / most)


def read_png(data: bytes, file: Path) -> npt.NDArray[np.float64]:
    """Shades in a PNG, 0 to 255, top row first, shape (rows, columns): the mean of its colours.

    Raises:
        InputError: The data of the file are no PNG, or are too large.
    """
    from matplotlib.image import imread

    columns, rows = _SIZE.unpack(data[16:24]) if data.startswith(_PNG) and len(data) >= 24 else (0, 0)
    if not 0 < columns * rows <= MOST_CELLS:  # before the image is unpacked
        raise InputError(Fault(f"cannot import an image of {columns} x {rows} cells as a PNG.", file))
    try:
        pixels = np.asarray(imread(BytesIO(data), format="png"), dtype=np.float64)
    except (OSError, SyntaxError, ValueError, EOFError, zlib.error, struct.error) as error:
        raise InputError(Fault(f"the image is damaged: {error}.", file)) from error
    if pixels.ndim == 2:
        return pixels * 255.0
    colours = pixels.shape[2] - 1 if pixels.shape[2] in (2, 4) else pixels.shape[2]  # without opacity
    mean: npt.NDArray[np.float64] = pixels[:, :, :colours].mean(axis=2) * 255.0
    return mean


def _image_bytes(file: Path) -> bytes:
    try:
        return read_bytes(file, 16 * MOST_CELLS)
    except OSError as error:
        raise InputError(Fault(f"cannot read the image: {error.strerror}.", file)) from error


def _words(body: bytes, count: int) -> npt.NDArray[np.float64]:
    words = re.sub(rb"#[^\n]*", b" ", body).split()[:count]
    return np.array([int(word) for word in words if word.isdigit() and len(word) < 6], dtype=np.float64)
