"""BARN: worlds and reference paths from a user's clone of the challenge (Perille et al., SSRR 2020)."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ...base.errors import Fault, InputError
from ...base.files import read_bytes, read_text
from ...base.geometry import Pose2
from ...compare.family import AgentSetup, Scene, goal_scenario, quantity
from ...compare.floor import Floor
from ...compare.obstacle import Block, Point, Post, length_of

START, GOAL = Pose2(-2.25, 3.0, math.pi / 2.0), (-2.25, 13.0)
TOLERANCE, DURATION = 1.0, 100.0  # [m], [s] as in the challenge
_FOLDERS = ("", "worlds/BARN", "jackal_helper/worlds/BARN")
_MAX_BYTES = 30_000_000  # maximum size of a world file; those of the challenge have half a megabyte
_MAX_OBSTACLES = 20_000


def read_barn(folder: Path, setup: AgentSetup | None = None) -> Iterator[Scene]:
    """Yield the scenes in a user's clone, by number, with the challenge's start, goal and time limit.

    Raises:
        InputError: There are no world files, or one is invalid; with file and line.
    """
    places = [folder / name for name in _FOLDERS]
    worlds = next((found for place in places if (found := _numbered(place, "world_*.world"))), None)
    if worlds is None:
        hint = "Give the path of your clone of the challenge, or of its folder jackal_helper/worlds/BARN."
        raise InputError(Fault("the folder has no world_0.world, world_1.world ...", folder, hint=hint))
    for number, file in sorted(worlds.items()):
        yield _scene(number, file, file.parent / "path_files" / f"path_{number}.npy", setup or AgentSetup())


def read_world(file: Path) -> list[Post | Block]:
    """Cylinders and boxes in a Gazebo world file (SDF).

    Only models directly in `<world>` count, since `<state>` repeats them.

    Raises:
        InputError: The file is not a valid world file; with the line.
    """
    root = _parse(file)
    world = root if root.tag == "world" else root.find("world")
    if world is None:
        raise InputError(Fault("the file has no <world>.", file, hint="Give an SDF world file of Gazebo."))
    obstacles: list[Post | Block] = []
    for model in world.findall("model"):
        at = _pose(model, file)
        for link in model.findall("link"):
            for collision in link.findall("collision"):
                obstacles += _obstacles(f"thing_{len(obstacles)}", at, link, collision, file)
                if len(obstacles) > _MAX_OBSTACLES:
                    raise InputError(Fault(f"the world has more than {_MAX_OBSTACLES} obstacles.", file))
    return obstacles


def _scene(number: int, file: Path, path: Path, setup: AgentSetup) -> Scene:
    obstacles, name = read_world(file), f"barn-{number}"
    reference = _reference_path(path)
    xs, ys = zip((START.x, START.y), GOAL, *((obstacle.x, obstacle.y) for obstacle in obstacles), strict=True)
    floor = Floor((min(xs) - 2.0, min(ys) - 2.0), (max(xs) + 2.0, max(ys) + 2.0), obstacles)
    posts = [obstacle for obstacle in obstacles if isinstance(obstacle, Post)]
    length = length_of(reference)
    difficulty = {"cylinders": float(len(posts)), "length": length, "clearance": floor.clearance(reference)}
    doc = f"World {number} of BARN: a field of cylinders, without a map."
    success = {"goal": "goal", "shortest_path": quantity(length, "m")}
    scenario = goal_scenario(
        setup, name, doc, START, GOAL, tolerance=TOLERANCE, duration=DURATION, agent={"success": success}
    )
    return Scene(scenario, floor, difficulty, tuple(reference))


def _reference_path(path: Path) -> list[Point]:
    """Reference path: the start, the centres of the published cells, the goal."""
    try:
        cells = np.load(BytesIO(read_bytes(path, _MAX_BYTES)), allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise InputError(Fault(f"cannot read the reference path: {error}.", path)) from error
    numbers = isinstance(cells, np.ndarray) and cells.dtype.kind in "iuf"
    if not numbers or cells.ndim != 2 or cells.shape[1] != 2 or not 1 <= len(cells) <= 10_000:
        shape = getattr(cells, "shape", "no array")
        raise InputError(Fault(f"a reference path has shape (n, 2), column and row; found shape {shape}.", path))
    if not (np.isfinite(cells).all() and np.abs(cells).max() < 1e4):
        raise InputError(Fault("the reference path has cells outside the map.", path))
    inner = [(0.15 * c - 0.075 - 4.5, 0.15 * r + 0.075 + 5.0) for c, r in cells.astype(float).tolist()]
    return [(START.x, START.y), *inner, GOAL]


def _numbered(folder: Path, pattern: str) -> dict[int, Path]:
    found = ((re.fullmatch(r"world_(\d{1,6})\.world", file.name), file) for file in folder.glob(pattern))
    return {int(match[1]): file for match, file in found if match}


def _parse(file: Path) -> Any:
    data = read_text(file, _MAX_BYTES)
    if "<!DOCTYPE" in data or "<!ENTITY" in data:
        raise InputError(Fault("a world file must not contain a document type or entities.", file))
    try:
        return ElementTree.fromstring(data)
    except (ElementTree.ParseError, ValueError, LookupError) as error:
        line, column = getattr(error, "position", (0, 0))
        raise InputError(Fault(f"not valid XML: {error}.", file, line, column)) from error


def _obstacles(name: str, model: Pose2, link: Any, collision: Any, file: Path) -> Iterator[Post | Block]:
    geometry = collision.find("geometry")
    if geometry is None:
        return
    at = model.compose(_pose(link, file)).compose(_pose(collision, file))
    if (cylinder := geometry.find("cylinder")) is not None:
        (radius,), (height,) = (_numbers(cylinder.findtext(tag), 1, tag, file) for tag in ("radius", "length"))
        _positive(file, radius, height)
        yield Post(name, at.x, at.y, radius, height)
    elif (box := geometry.find("box")) is not None:
        x, y, z = _numbers(box.findtext("size"), 3, "size", file)
        _positive(file, x, y, z)
        yield Block(name, at.x, at.y, x, y, at.yaw, z)


def _pose(element: Any, file: Path) -> Pose2:
    text = element.findtext("pose")
    if text is None:
        return Pose2(0.0, 0.0, 0.0)
    x, y, _, _, _, yaw = _numbers(text, 6, "pose", file)
    return Pose2(x, y, yaw)


def _numbers(text: str | None, count: int, what: str, file: Path) -> list[float]:
    try:
        numbers = [float(word) for word in (text or "").split()]
    except ValueError:
        numbers = []
    if len(numbers) != count or not all(abs(number) < 1e6 for number in numbers):
        raise InputError(Fault(f"a <{what}> must be {count} numbers, found {(text or '').strip()[:60]!r}.", file))
    return numbers


def _positive(file: Path, *sizes: float) -> None:
    if min(sizes) <= 1e-4:
        raise InputError(Fault(f"sizes must be positive, found {sizes}.", file))
