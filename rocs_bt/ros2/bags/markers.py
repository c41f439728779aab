"""Markers of a recorded world for rviz and Foxglove: obstacles, ground, places and hulls of bodies."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ...base.geometry import Pose3
from ...record import BodyInfo, Outline, Place, RunHeader
from ..messages.fields import Fields, pose_fields, time_fields, vector

_CYLINDER, _LINE_STRIP, _TEXT = 3, 4, 9  # types of markers
_WALL = {"r": 0.45, "g": 0.48, "b": 0.55, "a": 1.0}
_HULL = {"r": 0.16, "g": 0.36, "b": 0.75, "a": 1.0}
_GROUND = {"r": 0.60, "g": 0.45, "b": 0.30, "a": 1.0}
_PLACE = {"r": 0.10, "g": 0.60, "b": 0.35, "a": 0.6}
_ORIGIN = Pose3(0.0, 0.0, 0.0)


def scene(stamp: float, frame: str, header: RunHeader, bodies: Mapping[str, BodyInfo]) -> Fields:
    """Fields of a visualization_msgs/msg/MarkerArray.

    Args:
        stamp: Time [s].
        frame: Frame of the obstacles, ground and places.
        header: Header of the run; ground that is not level is drawn as its outline on the floor.
        bodies: Bodies by their frame; their hulls are drawn.
    """
    drawn = [
        *(each for outline in header.outlines for each in _outline(frame, outline)),
        *(_loop(frame, "ground", ground.points, 0.0, _GROUND) for ground in header.grounds),
        *(each for place in header.places for each in _place(frame, place)),
        *(_loop(where, "hulls", body.hull, z, _HULL) for where, body in bodies.items() for z in (0.0, body.height)),
    ]
    for number, marker in enumerate(drawn):
        marker["header"]["stamp"] = time_fields(stamp)
        marker["id"] = number
    return {"markers": drawn}


def _outline(frame: str, outline: Outline) -> list[Fields]:
    if outline.radius > 0.0:
        size, height = 2.0 * outline.radius, max(outline.height, 0.01)
        pose = Pose3(*outline.points[0], outline.height / 2.0)
        return [_marker(frame, "obstacles", _CYLINDER, vector(size, size, height), _WALL, pose)]
    return [_loop(frame, "obstacles", outline.points, z, _WALL) for z in (0.0, outline.height)]


def _place(frame: str, place: Place) -> list[Fields]:
    size = 2.0 * (place.radius or 0.1)
    disc = _marker(frame, "places", _CYLINDER, vector(size, size, 0.01), _PLACE, Pose3(place.x, place.y, 0.0))
    name = _marker(frame, "places", _TEXT, vector(0.0, 0.0, 0.12), _PLACE, Pose3(place.x, place.y, 0.2))
    return [disc, {**name, "text": place.name}]


def _loop(frame: str, kind: str, points: Sequence[tuple[float, float]], z: float, color: Fields) -> Fields:
    closed = [vector(x, y, z) for x, y in (*points, *points[:1])]
    return {**_marker(frame, kind, _LINE_STRIP, vector(0.02, 0.0, 0.0), color), "points": closed}


def _marker(frame: str, kind: str, shape: int, scale: Fields, color: Fields, pose: Pose3 = _ORIGIN) -> dict[str, Any]:
    return {
        "header": {"frame_id": frame},
        "ns": kind,
        "type": shape,
        "pose": pose_fields(pose),
        "scale": scale,
        "color": color,
        "frame_locked": True,  # hulls move with their bodies
    }
