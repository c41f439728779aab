"""Known ground: how far a robot may drive straight over ground that it has seen to be free or has driven over.

A range of +inf from a direction without a sensor is no echo, but no free ground either.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from ..base.errors import InputError
from ..base.geometry import Pose2, Twist2
from ..control.arcs import BENDS
from ..control.footprint import Footprint
from ..control.locomotion import Array
from ..interfaces.action import Body
from ..knowledge import UNKNOWN
from ..knowledge.robot import Scanner
from .room import Room

Mask = npt.NDArray[np.bool_]
"""One truth value for each point or pose."""

SCAN = "scan"
"""Name of the signal with the ranges of a laser scanner."""

STEP = 0.03
"""Distance between two checks of the ground [m]."""

MARGIN = 0.02
"""Distance from unknown ground and from obstacles at which the robot stops [m]."""

GAP = 0.12
"""Distance from the echoes of other ranges at which the robot stops; shorter ranges may be below the minimum [m]."""

GROUP = {1: "front", -1: "rear"}
"""Group of ranges in the direction of a speed."""


def known_speed(body: Body, speed: float, bend: float = 0.0) -> float:
    """Limit a speed such that the robot stops on known ground; 0 if there is none in its direction.

    Args:
        body: Robot.
        speed: Speed, negative backward [m/s].
        bend: Curvature of the drive, left positive for forward motion [rad/m].
    """
    if speed == 0.0:
        return 0.0
    stop = body.locomotion.stop_distance(Twist2(speed, speed * bend)) + abs(speed) * body.period
    room = known_room(body, 1 if speed > 0.0 else -1, bend, stop + MARGIN + STEP) - MARGIN
    if room >= stop:
        return speed
    return speed * room / stop if room > MARGIN else 0.0


def known_bend(body: Body, speed: float, bend: float) -> float:
    """Curvature with known ground: the given one if the robot has ground there, else that with the most [rad/m].

    Robots without the signals `room_ahead` and `room_behind` know the ground straight ahead and behind only.
    """
    if not _has_rooms(body) or known_speed(body, speed, bend):
        return bend
    room = Room.known(body)
    rooms = room.ahead if speed > 0.0 else room.behind
    return BENDS[int(rooms.argmax())] if rooms.max() > 0.0 else bend


def known_room(body: Body, sign: int, bend: float, reach: float) -> float:
    """Length of the known free ground ahead or behind [m]; at least `reach` if nothing limits it.

    Robots with the signals `room_ahead` and `room_behind` know it on arcs. Those with a laser scanner know what it sees
    now, and what it has seen by the map of LocalMap. Others know the ground up to the echoes of the group in this
    direction, and none in a blind direction. Ground on which the robot has been is known to all.

    Args:
        body: Robot.
        sign: 1 ahead, -1 behind.
        bend: Curvature, left positive for forward motion [rad/m].
        reach: Distance that is of interest [m].
    """
    signals, robot, room = body.knowledge.signals, body.knowledge.robot, 0.0
    if _has_rooms(body):
        rooms = Room.known(body)
        arc = int(np.abs(np.array(BENDS) - bend).argmin())
        room = float((rooms.ahead if sign > 0 else rooms.behind)[arc])
    scanner = _scanner(body)
    if not _has_rooms(body) and scanner is None and GROUP[sign] in signals and GROUP[sign] not in robot.blind:
        return float(np.nan_to_num(signals.read(GROUP[sign], body.clock.now()).min() - GAP, nan=0.0, posinf=math.inf))
    pose, hull = robot.pose(body.clock.now()), robot.hull
    if room >= reach or hull is None or math.isnan(pose.x + pose.yaw):
        return room
    steps = np.arange(1.0, math.ceil(reach / STEP) + 1.0) * STEP
    points = _new_ground(hull, sign, steps)
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    world = points @ np.array([[c, s], [-s, c]]) + (pose.x, pose.y)
    known = np.zeros(len(points), dtype=bool)
    if scanner is not None:
        known = _in_scan(body, scanner, points) | _in_map(body, world)
    if not known.all():
        known[~known] = body.trail.covers(world[~known], hull)
    free = known.reshape(len(steps), -1).all(axis=1) & _clear(body, hull, pose, sign * steps)
    return math.inf if free.all() else max(room, float(STEP * free.argmin()))


def _has_rooms(body: Body) -> bool:
    signals = body.knowledge.signals
    return "room_ahead" in signals or "room_behind" in signals


def _scanner(body: Body) -> Scanner | None:
    if SCAN not in body.knowledge.signals or body.knowledge.robot.hull is None:
        return None
    try:
        return body.knowledge.robot.scanner(SCAN)
    except InputError:
        return None


def _new_ground(hull: Footprint, sign: int, steps: Array) -> Array:
    """Points that the hull newly covers after each step, body frame, shape (n, 2) [m]; equally many for each step."""
    across = np.linspace(-0.5, 0.5, 2 + math.ceil(hull.width / STEP)) * (hull.width - MARGIN)
    x = np.repeat(sign * (0.5 * hull.length + steps), len(across))
    return np.column_stack([x, np.tile(across, len(steps))])


def _in_map(body: Body, points: Array) -> Mask:
    """Whether points, world frame, shape (n, 2), are in observed cells of the map, shape (n,), bool."""
    grid = body.knowledge.world.occupancy
    if grid is None:
        return np.zeros(len(points), dtype=bool)
    low, high = points.min(axis=0), points.max(axis=0)
    window, cells = grid.window((low[0], low[1]), (high[0], high[1])), grid.cells(points)
    rows, columns = (cells - cells.min(axis=0)).T
    observed: Mask = window.states[rows, columns] != UNKNOWN
    return observed


def _in_scan(body: Body, scanner: Scanner, points: Array) -> Mask:
    """Whether the present scan passes over points, body frame, shape (n, 2); shape (n,), bool."""
    ranges, mount = body.knowledge.signals.read(SCAN, body.clock.now()), scanner.mount
    dx, dy = points[:, 0] - mount.x, points[:, 1] - mount.y
    bearing = (np.arctan2(dy, dx) - mount.yaw + math.pi) % math.tau - math.pi
    step = scanner.span / (scanner.rays - 1)
    ray = np.rint((bearing + 0.5 * scanner.span) / step).astype(np.intp)
    around = scanner.span + 1.5 * step > math.tau
    inside = np.full(len(ray), around) | ((ray >= 0) & (ray < scanner.rays))
    beside = np.clip(ray[:, None] + np.array([-1, 0, 1]), 0, scanner.rays - 1)
    free: Mask = ranges[beside].min(axis=1) > np.hypot(dx, dy)
    return inside & free


def _clear(body: Body, hull: Footprint, pose: Pose2, moves: Array) -> Mask:
    """Whether the hull does not touch an obstacle of the map after moves straight ahead, shape (k,) [m]; (k,), bool.

    An obstacle that is within the margin already may not come nearer.
    """
    grid = body.knowledge.world.occupancy
    if grid is None:
        return np.ones(len(moves), dtype=bool)
    x, y = pose.x + math.cos(pose.yaw) * moves, pose.y + math.sin(pose.yaw) * moves
    poses, reach = np.column_stack([x, y, np.full(len(moves), pose.yaw)]), hull.outer + STEP
    points = grid.points((x.min() - reach, y.min() - reach), (x.max() + reach, y.max() + reach))
    now, *gaps = hull.clearance(np.vstack([pose, poses]), points).tolist()
    clear: Mask = np.array(gaps) >= min(MARGIN, now) - 1e-3
    return clear
