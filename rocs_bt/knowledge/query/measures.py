"""What queries measure on poses and paths: plain functions, which the generated code of a query calls."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

from ...geometry import Pose2, wrap_angle
from .parameter import Path


def number(value: float | None) -> float:
    """A number as expressions read it: NaN where it is not known."""
    if value is None:
        return math.nan
    try:
        return float(value)
    except OverflowError:  # a whole number beyond float64
        return math.inf if value > 0 else -math.inf


def equal(a: str | None, b: str | None) -> float:
    """1 where two texts are the same, 0 where not, NaN where one is not known."""
    return math.nan if a is None or b is None else float(a == b)


def apart(a: Pose2 | Path | None, b: Pose2 | Path | None) -> float:
    """How far two poses, or a pose and a path, are from each other [m]; NaN where one is not known."""
    if a is None or b is None:
        return math.nan
    if isinstance(a, Pose2) and isinstance(b, Pose2):
        return math.hypot(a.x - b.x, a.y - b.y)
    pose, path = (a, b) if isinstance(a, Pose2) else (b, a)
    return _beside(pose[0], pose[1], path)  # type: ignore[arg-type]  # one of the two is a path: `Scope` sees to it


def direction(a: Pose2 | None, b: Pose2 | None) -> float:
    """Where a is as seen from b: the angle from b's heading, left positive [rad]; NaN where one is not known."""
    return math.nan if a is None or b is None else wrap_angle(math.atan2(a.y - b.y, a.x - b.x) - b.yaw)


def circle(place: Pose2 | Path) -> tuple[float, float, float]:
    """A circle around a pose or a path: centre and radius [m]."""
    if isinstance(place, Pose2):
        return place.x, place.y, 0.0
    xs, ys = zip(*place, strict=True)
    x, y = (min(xs) + max(xs)) / 2.0, (min(ys) + max(ys)) / 2.0
    return x, y, max(math.hypot(px - x, py - y) for px, py in place)


def _beside(x: float, y: float, path: Path) -> float:
    """How far a point is from a chain of straight lines [m]."""
    best = math.hypot(path[0][0] - x, path[0][1] - y)
    for (ax, ay), (bx, by) in pairwise(path):
        dx, dy = bx - ax, by - ay
        square = dx * dx + dy * dy
        along = 0.0 if square == 0.0 else min(1.0, max(0.0, ((x - ax) * dx + (y - ay) * dy) / square))
        best = min(best, math.hypot(ax + along * dx - x, ay + along * dy - y))
    return best


HELPERS: dict[str, Any] = {
    "number": number, "equal": equal, "apart": apart, "direction": direction, "nan": math.nan,
}  # fmt: skip
