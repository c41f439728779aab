"""Poses through the transforms (TF) that the robot publishes."""

from __future__ import annotations

import math
from typing import Any

from ...base.errors import DeviceError
from .takes import pose3

Quaternion = tuple[float, float, float, float]
Vector = tuple[float, float, float]


class Frames:
    """Newest transform of each frame from its parent.

    Transforms are not interpolated: a pose has the stamp of the oldest moving transform on its way.
    """

    def __init__(self) -> None:
        self._parents: dict[str, tuple[str, Vector, Quaternion, float]] = {}

    def add(self, message: Any, stamp: float) -> None:
        """Add the transforms of a TFMessage.

        Args:
            message: The message.
            stamp: Time of the transforms [s]; +inf for static ones.

        Raises:
            DeviceError: A transform is faulty; the others of the message are added.
        """
        fault: DeviceError | None = None
        for each in message.transforms:
            move, turn = each.transform.translation, each.transform.rotation
            try:
                pose3(move, turn)
            except DeviceError as error:
                fault = DeviceError(f"transform of '{each.child_frame_id}': {error}")
                continue
            place = (float(move.x), float(move.y), float(move.z))
            rotation = (float(turn.w), float(turn.x), float(turn.y), float(turn.z))
            parent = each.header.frame_id.lstrip("/")
            self._parents[each.child_frame_id.lstrip("/")] = (parent, place, rotation, stamp)
        if fault is not None:
            raise fault

    def pose(self, frame: str, child: str) -> tuple[Vector, Quaternion, float]:
        """Position [m] and orientation (w, x, y, z) of a frame in one of its ancestors, and the stamp [s].

        Raises:
            DeviceError: The frames are not connected.
        """
        place: Vector = (0.0, 0.0, 0.0)
        rotation: Quaternion = (1.0, 0.0, 0.0, 0.0)
        stamp, at, seen = math.inf, child.lstrip("/"), set[str]()
        while at != frame.lstrip("/"):
            if at not in self._parents or at in seen:
                known = ", ".join(sorted(self._parents)) or "none"
                raise DeviceError(f"no transforms lead from '{frame}' to '{child}'; frames with transforms: {known}")
            seen.add(at)
            at, move, turn, own = self._parents[at]
            turned = _rotated(turn, place)
            place = (move[0] + turned[0], move[1] + turned[1], move[2] + turned[2])
            rotation, stamp = _product(turn, rotation), min(stamp, own)
        return place, rotation, stamp


def _product(a: Quaternion, b: Quaternion) -> Quaternion:
    (w, x, y, z), (s, i, j, k) = a, b
    return (
        w * s - x * i - y * j - z * k,
        w * i + x * s + y * k - z * j,
        w * j - x * k + y * s + z * i,
        w * k + x * j - y * i + z * s,
    )


def _rotated(turn: Quaternion, vector: Vector) -> Vector:
    w, x, y, z = turn
    _, i, j, k = _product(_product(turn, (0.0, *vector)), (w, -x, -y, -z))
    return (i, j, k)
