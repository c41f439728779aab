"""FollowPath: drive along a path."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from ..action import Action, Body, MacroAction
from ..control.path import Path
from ..geometry import Pose2
from ..units import LENGTH, NOT_NEGATIVE, Metres, PositiveMetres, PositiveMetresPerSecond
from .following import OFF, PathDrive

if TYPE_CHECKING:
    from ..knowledge import Knowledge

AGAIN = 0.1  # [m] Of places that are nearest to within this, the first on the path counts: it may cross itself.


@dataclass(kw_only=True, eq=False)
class FollowPath(MacroAction):
    """Drive along a polyline with the follower, and stand at its end.

    It joins the path at the nearest place, so a mission that sends it again after a reflex goes on where it was.

    Attributes:
        points: Corners as (x, y) in the world frame [m].
        cruise: Speed on the straight [m/s].
        tolerance: Distance from the end at which it is done, standing [m].
        corner_radius: Of the arcs that round the corners [m].
    """

    points: Annotated[Sequence[Sequence[float]], LENGTH]
    cruise: PositiveMetresPerSecond = 0.5
    tolerance: PositiveMetres = 0.05
    corner_radius: Annotated[Metres, NOT_NEGATIVE] = 0.2

    def decompose(self, body: Body) -> Iterator[Action]:
        whole = Path.through([list(p[:2]) for p in self.points], self.corner_radius)
        drive, end = PathDrive(body, self.cruise), Pose2(*whole.position(whole.length).tolist())
        while True:
            pose = drive.pose()
            if pose is None:
                yield drive.brake()
                continue
            there = pose.distance(end) <= self.tolerance
            if drive.remaining <= 2.0 * self.tolerance and there and drive.standing():
                return
            missed = drive.remaining < 0.5 * self.tolerance and not there
            if drive.lost or missed:
                driven = 0.0 if math.isinf(drive.remaining) else whole.length - drive.remaining
                drive.begin(_rest(whole, pose, whole.length if missed else _nearest(whole, pose, driven)))
            yield drive.step(pose)

    def remaining(self, knowledge: Knowledge) -> float:
        path, pose = Path.through([list(p[:2]) for p in self.points]), knowledge.robot.pose()
        return path.length - path.project(pose.x, pose.y) if math.isfinite(pose.x) else math.nan


def _nearest(path: Path, pose: Pose2, driven: float) -> float:
    """Where to join [m]: not before what is driven already, and of equally near places the first."""
    stations = np.linspace(0.0, path.length, len(path.samples))
    away = np.hypot(path.samples[:, 0] - pose.x, path.samples[:, 1] - pose.y)
    away[stations < driven - OFF] = np.inf
    first = int(np.argmax(away <= away.min() + AGAIN))
    return path.project(pose.x, pose.y, hint=float(stations[first]), window=OFF)


def _rest(path: Path, pose: Pose2, s: float) -> Path:
    """The way from the robot to the path at s [m], and on along it."""
    ahead = path.position(np.arange(s, path.length, path.spacing or 1.0)) if s < path.length else np.empty((0, 2))
    start = [[pose.x, pose.y]] if math.hypot(*(path.position(s) - pose[:2])) > 0.5 * OFF else []
    return Path([*start, *ahead.tolist(), path.position(path.length).tolist()])
