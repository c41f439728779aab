"""Raster maps: the YAML files of ROS's map server, with images as portable graymaps or PNG."""

from __future__ import annotations

import math
import re
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

import numpy as np
import numpy.typing as npt

from ...base.errors import Fault, InputError
from ...base.files import read_bytes, read_text
from ...compare.floor_grid import FloorGrid

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
