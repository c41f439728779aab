"""JSON schemas of the Foxglove messages that rocs_bt writes.

Names, fields and enumerations are those of the published schemas of the Foxglove SDK (MIT licence).
"""

from __future__ import annotations

from typing import Any

import msgspec

Json = dict[str, Any]


def _object(title: str, **fields: Json) -> Json:
    return {"title": title, "type": "object", "properties": fields}


def _list(items: Json) -> Json:
    return {"type": "array", "items": items}


def _numbers(title: str, *names: str) -> Json:
    return _object(title, **{name: {"type": "number"} for name in names})


_NUMBER: Json = {"type": "number"}
_TEXT: Json = {"type": "string"}
_TRUTH: Json = {"type": "boolean"}
_WHOLE: Json = {"type": "integer"}
_TIME = _object("time", sec={"type": "integer", "minimum": 0}, nsec={"type": "integer", "minimum": 0})
_DURATION = _object("duration", sec=_WHOLE, nsec=_WHOLE)
_VECTOR = _numbers("foxglove.Vector3", "x", "y", "z")
_POINT = _numbers("foxglove.Point3", "x", "y", "z")
_QUATERNION = _numbers("foxglove.Quaternion", "x", "y", "z", "w")
_COLOR = _numbers("foxglove.Color", "r", "g", "b", "a")
_POSE = _object("foxglove.Pose", position=_VECTOR, orientation=_QUATERNION)
_LINE = _object(
    "foxglove.LinePrimitive",
    type={
        "type": "integer",
        "oneOf": [
            {"title": "LINE_STRIP", "const": 0},
            {"title": "LINE_LOOP", "const": 1},
            {"title": "LINE_LIST", "const": 2},
        ],
    },
    pose=_POSE,
    thickness=_NUMBER,
    scale_invariant=_TRUTH,
    points=_list(_POINT),
    color=_COLOR,
    colors=_list(_COLOR),
    indices=_list(_WHOLE),
)
_CYLINDER = _object(
    "foxglove.CylinderPrimitive",
    pose=_POSE,
    size=_VECTOR,
    bottom_scale=_NUMBER,
    top_scale=_NUMBER,
    color=_COLOR,
)
_TRIANGLES = _object(
    "foxglove.TriangleListPrimitive",
    pose=_POSE,
    points=_list(_POINT),
    color=_COLOR,
    colors=_list(_COLOR),
    indices=_list(_WHOLE),
)
_TEXT_PRIMITIVE = _object(
    "foxglove.TextPrimitive",
    pose=_POSE,
    billboard=_TRUTH,
    font_size=_NUMBER,
    scale_invariant=_TRUTH,
    color=_COLOR,
    text=_TEXT,
)
_ENTITY = _object(
    "foxglove.SceneEntity",
    timestamp=_TIME,
    frame_id=_TEXT,
    id=_TEXT,
    lifetime=_DURATION,
    frame_locked=_TRUTH,
    metadata=_list(_object("foxglove.KeyValuePair", key=_TEXT, value=_TEXT)),
    arrows=_list({"type": "object"}),
    cubes=_list({"type": "object"}),
    spheres=_list({"type": "object"}),
    cylinders=_list(_CYLINDER),
    lines=_list(_LINE),
    triangles=_list(_TRIANGLES),
    texts=_list(_TEXT_PRIMITIVE),
    models=_list({"type": "object"}),
)
_DELETION = _object("foxglove.SceneEntityDeletion", timestamp=_TIME, type=_WHOLE, id=_TEXT)

POSE = "foxglove.PoseInFrame"
TRANSFORM = "foxglove.FrameTransform"
SCENE = "foxglove.SceneUpdate"
LOG = "foxglove.Log"

_SCHEMAS: dict[str, Json] = {
    POSE: _object(POSE, timestamp=_TIME, frame_id=_TEXT, pose=_POSE),
    TRANSFORM: _object(
        TRANSFORM,
        timestamp=_TIME,
        parent_frame_id=_TEXT,
        child_frame_id=_TEXT,
        translation=_VECTOR,
        rotation=_QUATERNION,
    ),
    SCENE: _object(SCENE, deletions=_list(_DELETION), entities=_list(_ENTITY)),
    LOG: _object(
        LOG,
        timestamp=_TIME,
        level={"type": "integer", "minimum": 0, "maximum": 5},
        message=_TEXT,
        name=_TEXT,
        file=_TEXT,
        line={"type": "integer", "minimum": 0},
    ),
}


def schema(name: str) -> bytes:
    """JSON schema of one of these messages."""
    return msgspec.json.encode(_SCHEMAS[name])


def timestamp(time: int) -> Json:
    """Convert a time [ns] to a Foxglove timestamp."""
    return {"sec": time // 1_000_000_000, "nsec": time % 1_000_000_000}


def pose(x: float = 0.0, y: float = 0.0, z: float = 0.0) -> Json:
    """Pose at a point [m], without rotation."""
    return {"position": {"x": x, "y": y, "z": z}, "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}


def entity(time: int, frame: str, name: str, **primitives: list[Json]) -> Json:
    """Scene entity in a frame, shown until an entity of the same name replaces it."""
    kinds = ("arrows", "cubes", "spheres", "cylinders", "lines", "triangles", "texts", "models")
    return {
        "timestamp": timestamp(time),
        "frame_id": frame,
        "id": name,
        "lifetime": {"sec": 0, "nsec": 0},
        "frame_locked": True,
        "metadata": [],
        **{kind: primitives.get(kind, []) for kind in kinds},
    }


def line(kind: int, points: list[tuple[float, float, float]], color: Json, thickness: float) -> Json:
    """Line primitive through points [m]; kind 0 is a strip, 1 a loop, 2 a list of segments; thickness in metres."""
    return {
        "type": kind,
        "pose": pose(),
        "thickness": thickness,
        "scale_invariant": False,
        "points": [{"x": x, "y": y, "z": z} for x, y, z in points],
        "color": color,
        "colors": [],
        "indices": [],
    }
