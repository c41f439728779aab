"""Parameters of a query: named numbers, quantities, booleans, texts, poses and paths passed from Python.

knowledge.ask("object where distance(pose, way) < reach", way=[Pose2(0, 0), Pose2(3, 1)], reach=parse_quantity("0.5 m"))
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, TypeAlias

from ...base.errors import KnowledgeError
from ...base.geometry import Pose2, wrap_angle
from ...base.units import NONE, Dimension, Quantity

Point: TypeAlias = tuple[float, float]
Path: TypeAlias = tuple[Point, ...]


@dataclass(frozen=True)
class Parameter:
    """Type of a parameter.

    Attributes:
        type: Python type: `float`, `bool`, `str`, `Pose2`, or `tuple` for a path.
        dimension: Dimension of a number.
    """

    type: type
    dimension: Dimension = NONE

    def __str__(self) -> str:
        words = {bool: "a truth value", str: "a text", Pose2: "a pose", tuple: "a path"}
        return words.get(self.type, f"a number [{self.dimension}]")


def read_parameter(name: str, value: Any) -> tuple[Parameter, Any]:
    """Type of a parameter's value, and the value in the form that a query reads: SI units, paths as (x, y) points.

    Args:
        name: Name of the parameter, for messages.
        value: A number, a Quantity, a bool, a text, a Pose2, or a path of at least one pose or (x, y) [m].

    Raises:
        KnowledgeError: Any other value.
    """
    if isinstance(value, bool):
        return Parameter(bool), value
    if isinstance(value, Quantity):
        return Parameter(float, value.dimension), value.value
    if isinstance(value, (int, float)):
        return Parameter(float), float(value)
    if isinstance(value, str):
        return Parameter(str), value
    if isinstance(value, Pose2):
        return Parameter(Pose2), value
    points = _points(value)
    if not points or not all(map(math.isfinite, (number for point in points for number in point))):
        raise KnowledgeError(
            f"the parameter '{name}' must be a number, a Quantity, a text, True or False, a Pose2 or a path of poses "
            f"or (x, y); found {value!r}."
        )
    return Parameter(tuple), points


def read_parameters(given: Mapping[str, Any]) -> tuple[dict[str, Parameter], dict[str, Any]]:
    """Types and values of all parameters, each by name; see `read_parameter`.

    Raises:
        KnowledgeError: A value has an unsupported type.
    """
    read = {name: read_parameter(name, value) for name, value in given.items()}
    return {name: kind for name, (kind, _) in read.items()}, {name: value for name, (_, value) in read.items()}


def _points(value: Any) -> Path:
    if not isinstance(value, Iterable):
        return ()
    try:
        return tuple((float(point[0]), float(point[1])) for point in value)
    except (TypeError, ValueError, IndexError, OverflowError):
        return ()


def number(value: float | None) -> float:
    """A number in the form that expressions read: a float, NaN if unknown."""
    if value is None:
        return math.nan
    try:
        return float(value)
    except OverflowError:  # an integer beyond float64
        return math.inf if value > 0 else -math.inf


def equal(a: str | None, b: str | None) -> float:
    """1 if two texts are equal, 0 if not, NaN if one is unknown."""
    return math.nan if a is None or b is None else float(a == b)


def apart(a: Pose2 | Path | None, b: Pose2 | Path | None) -> float:
    """Distance between two poses, or between a pose and a path [m]; NaN if one is unknown."""
    if a is None or b is None:
        return math.nan
    if isinstance(a, Pose2) and isinstance(b, Pose2):
        return math.hypot(a.x - b.x, a.y - b.y)
    pose, path = (a, b) if isinstance(a, Pose2) else (b, a)
    return _path_distance(pose[0], pose[1], path)  # type: ignore[arg-type]  # `ExpressionScope` ensures that one is a path


def direction(a: Pose2 | None, b: Pose2 | None) -> float:
    """Bearing of a as seen from b: the angle from b's heading, left positive [rad]; NaN if one is unknown."""
    return math.nan if a is None or b is None else wrap_angle(math.atan2(a.y - b.y, a.x - b.x) - b.yaw)


def circle(place: Pose2 | Path) -> tuple[float, float, float]:
    """Bounding circle of a pose or a path: centre x, y and radius [m]."""
    if isinstance(place, Pose2):
        return place.x, place.y, 0.0
    xs, ys = zip(*place, strict=True)
    x, y = (min(xs) + max(xs)) / 2.0, (min(ys) + max(ys)) / 2.0
    return x, y, max(math.hypot(px - x, py - y) for px, py in place)


def _path_distance(x: float, y: float, path: Path) -> float:
    """Distance from a point to a polyline [m]."""
    best = math.hypot(path[0][0] - x, path[0][1] - y)
    for (ax, ay), (bx, by) in pairwise(path):
        dx, dy = bx - ax, by - ay
        square = dx * dx + dy * dy
        along = 0.0 if square == 0.0 else min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / square))
        best = min(best, math.hypot(ax + along * dx - x, ay + along * dy - y))
    return best


HELPERS: dict[str, Any] = {
    "number": number,
    "equal": equal,
    "apart": apart,
    "direction": direction,
    "nan": math.nan,
}
