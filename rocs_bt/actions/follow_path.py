"""FollowPath: drive along a path."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated

import numpy as np

from ..base.geometry import Pose2
from ..base.units import LENGTH, NOT_NEGATIVE, Metres, PositiveMetres, PositiveMetresPerSecond
from ..control.path import Path
from ..interfaces.action import Action, Body
from .heading import ALONG
from .path_action import Height, PathAction
from .path_drive import OFF

if TYPE_CHECKING:
    from ..knowledge import Knowledge

AGAIN = 0.1  # [m] of points that are at most this much farther than the nearest, the first on the path is joined


class FollowPath(PathAction):
    """Drive along a polyline with the follower, and stop at its end.

    The robot joins the path at the nearest point, so a mission that resubmits the action after a reflex continues where
    it was.

    Attributes:
        points: Corners as (x, y), world frame [m].
        cruise: Speed on straight parts [m/s].
        tolerance: Distance from the end at which the stationary robot has arrived, also in height [m].
        corner_radius: Radius of the arcs that round the corners [m].
        heading: Yaw on the way: `along` the path, `keep`, an angle such as `90 deg`, or `look_at PLACE`.
            An angle holds on arrival, too, within 5 deg.
        height: Height to fly at [m], 0.15 m away from what `above` and `below` detect; no change by default.
    """

    points: Annotated[Sequence[Sequence[float]], LENGTH]
    cruise: PositiveMetresPerSecond = 0.5
    tolerance: PositiveMetres = 0.05
    corner_radius: Annotated[Metres, NOT_NEGATIVE] = 0.2
    heading: str = ALONG
    height: Height = math.inf

    def decompose(self, body: Body) -> Iterator[Action]:
        whole = Path.through([list(p[:2]) for p in self.points], self.corner_radius)
        drive, end = self.path_drive(body, self.cruise), Pose2(*whole.position(whole.length).tolist())
        while True:
            pose = drive.pose()
            if pose is None:
                yield drive.brake()
                continue
            there = pose.distance(end) <= self.tolerance + body.locomotion.sway
            arrived = drive.remaining <= 2.0 * self.tolerance and there and drive.at_height(self.tolerance)
            if arrived and drive.faces(pose) and drive.stationary():
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
    """Arc length at which to join the path [m]: that of the nearest point which the robot has not yet passed."""
    stations = np.linspace(0.0, path.length, len(path.samples))
    away = np.hypot(path.samples[:, 0] - pose.x, path.samples[:, 1] - pose.y)
    away[stations < driven - OFF] = np.inf
    first = int(np.argmax(away <= away.min() + AGAIN))
    return path.project(pose.x, pose.y, hint=float(stations[first]), window=OFF)


def _rest(path: Path, pose: Pose2, s: float) -> Path:
    """Path from the robot to the point at arc length s [m] of another path, and from there along that path."""
    ahead = path.position(np.arange(s, path.length, path.spacing or 1.0)) if s < path.length else np.empty((0, 2))
    start = [[pose.x, pose.y]] if math.hypot(*(path.position(s) - pose[:2])) > 0.5 * OFF else []
    return Path([*start, *ahead.tolist(), path.position(path.length).tolist()])
