"""Viewer: converts events to messages for Foxglove-compatible viewers: poses, frames, beams, logs, the world."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator

import msgspec
import numpy as np

from ... import event as ev
from ...base.geometry import Pose3
from ...event import Event
from . import foxglove
from .header import Beam, BodyInfo, Outline, Place, RunHeader

Message = tuple[str, str, bytes]  # topic, name of the schema, JSON
Draw = Callable[..., Iterable[Message]]
WORLD = "world"
_WALL = {"r": 0.45, "g": 0.48, "b": 0.55, "a": 1.0}
_HULL = {"r": 0.16, "g": 0.36, "b": 0.75, "a": 1.0}
_BEAM = {"r": 0.95, "g": 0.60, "b": 0.10, "a": 0.55}
_GROUND = {"r": 0.60, "g": 0.45, "b": 0.30, "a": 1.0}
_PLACE = {"r": 0.10, "g": 0.60, "b": 0.35, "a": 0.9}

# String templates are faster than dictionaries; they are filled for every body.
_EVERY = 100_000_000  # [ns] period of poses and beams for viewers; events are recorded at the full rate
_STAMP = '{"timestamp":{"sec":%d,"nsec":%d},'
_POSE = (
    _STAMP + '"frame_id":"world","pose":{"position":{"x":%.5f,"y":%.5f,"z":%s},'
    '"orientation":{"x":%s,"y":%s,"z":%.7f,"w":%.7f}}}'
)
_FRAME = (
    _STAMP + '"parent_frame_id":"world","child_frame_id":%s,"translation":{"x":%.5f,"y":%.5f,"z":%s},'
    '"rotation":{"x":%s,"y":%s,"z":%.7f,"w":%.7f}}'
)


class FoxgloveMessages:
    """Converts events to messages for Foxglove-compatible viewers; poses and beams at 10 Hz."""

    def __init__(self, header: RunHeader) -> None:
        self._header = header
        self._beams = {(body.name, sensor): _BeamLines(body, sensor) for body in header.bodies for sensor in body.beams}
        self._next: dict[object, int] = {}  # earliest time of the next pose of a body, or beams of a sensor [ns]
        self._draw: dict[type[Event], Draw] = {
            ev.BodyMoved: self._moved,
            ev.SensorRead: self._read,
        }

    def converter(self, kind: type[Event]) -> Draw | None:
        """Function that makes messages from an event of this kind and a time [ns]; None for kinds without messages."""
        return self._draw.get(kind) or (None if kind.sentence is Event.sentence else self._log)

    def scene(self, time: int) -> Message:
        """Message with the obstacles, ground, places and hulls of bodies, sent once at the beginning."""
        outlines = [_outline(o, time) for o in self._header.outlines]
        grounds = [_ground(o, time) for o in self._header.grounds]
        places = [_place(p, time) for p in self._header.places]
        hulls = [_hull(b, time) for b in self._header.bodies if b.hull]
        return (
            "/world/scene",
            foxglove.SCENE,
            _json({"deletions": [], "entities": [*outlines, *grounds, *places, *hulls]}),
        )

    def _log(self, event: Event, time: int) -> Iterator[Message]:
        if event.sentence:
            name, stamp = event.agent or WORLD, foxglove.timestamp(time)
            line = {"timestamp": stamp, "level": event.level, "message": event.sentence, "name": name}
            yield f"/{name}/log", foxglove.LOG, _json({**line, "file": "", "line": 0})

    def _due(self, source: object, time: int) -> bool:
        """Whether a source sends a message at a time [ns], and then the next one a period later."""
        if time < self._next.get(source, 0):
            return False
        self._next[source] = time + _EVERY - 1000  # slightly early, since times are rounded
        return True

    def _moved(self, event: ev.BodyMoved, time: int) -> Iterable[Message]:
        pose = Pose3(event.x, event.y, event.height or 0.0, event.roll or 0.0, event.pitch or 0.0, event.yaw)
        if not math.isfinite(sum(pose)) or not self._due(event.body, time):
            return ()
        name = msgspec.json.encode(event.body).decode()
        sec, nsec = divmod(time, 1_000_000_000)
        height, i, j, k, w = "0.0", "0.0", "0.0", math.sin(event.yaw / 2.0), math.cos(event.yaw / 2.0)
        if event.height is not None:
            w, *turn, k = pose.quaternion
            height, i, j = (f"{value:.7f}" for value in (pose.z, *turn))
        placed = event.x, event.y, height, i, j, k, w
        return (
            (f"/{event.body}/pose", foxglove.POSE, (_POSE % (sec, nsec, *placed)).encode()),
            ("/tf", foxglove.TRANSFORM, (_FRAME % (sec, nsec, name, *placed)).encode()),
        )

    def _read(self, event: ev.SensorRead, time: int) -> Iterable[Message]:
        source = event.agent, event.sensor
        lines = self._beams.get(source)
        if lines is None or len(event.data) != 8 * lines.count or not self._due(source, time):
            return ()
        return ((lines.topic, foxglove.SCENE, lines.fill(event.data, time)),)


class _BeamLines:
    """Template of the beams of one range sensor, as lines in the body frame."""

    def __init__(self, body: BodyInfo, sensor: str) -> None:
        beams = body.beams[sensor]
        self.topic = f"/{body.name}/{sensor}/beams"
        self.count = len(beams)
        self._rays = [(b.x, b.y, body.height, *_direction(b), b.reach) for b in beams]
        # Start points are constant. End points are encoded as a marker, which becomes a format field.
        points = [p for b in beams for p in ((b.x, b.y, body.height), (7e77, 7e77, 7e77))]
        lines = [foxglove.line(2, points, _BEAM, 0.01)]
        update = {
            "deletions": [],
            "entities": [foxglove.entity(0, body.name, f"{body.name}/{sensor}", lines=lines)],
        }
        text = _json(update).decode().replace("%", "%%").replace("7e77", "%.3f")
        self._template = text.replace('"timestamp":{"sec":0,"nsec":0}', '"timestamp":{"sec":%d,"nsec":%d}', 1)

    def fill(self, data: bytes, time: int) -> bytes:
        ends: list[float] = []
        for (x, y, z, along, across, up, reach), distance in zip(self._rays, ev.unpack(data), strict=True):
            # A beam without echo is drawn to the sensor's maximum range, an invalid one not at all.
            shown = 0.0 if math.isnan(distance) else min(distance, reach)
            ends += (x + along * shown, y + across * shown, z + up * shown)
        return (self._template % (*divmod(time, 1_000_000_000), *ends)).encode()


def _direction(beam: Beam) -> tuple[float, float, float]:
    """Unit vector of a beam, body frame."""
    flat = math.cos(beam.elevation)
    return flat * math.cos(beam.yaw), flat * math.sin(beam.yaw), math.sin(beam.elevation)


def _outline(outline: Outline, time: int) -> foxglove.Json:
    points = [(x, y, 0.0) for x, y in outline.points]
    top = [(x, y, outline.height) for x, y in outline.points]
    if outline.radius > 0.0:
        size = 2.0 * outline.radius
        disc = {
            "pose": foxglove.pose(*outline.points[0], outline.height / 2.0),
            "size": {"x": size, "y": size, "z": outline.height},
            "bottom_scale": 1.0,
            "top_scale": 1.0,
            "color": _WALL,
        }
        return foxglove.entity(time, WORLD, outline.name, cylinders=[disc])
    loops = [foxglove.line(1, loop, _WALL, 0.02) for loop in (points, top)]
    return foxglove.entity(time, WORLD, outline.name, lines=loops)


def _ground(ground: Outline, time: int) -> foxglove.Json:
    """Outline on the floor of ground that is not level."""
    loop = foxglove.line(1, [(x, y, 0.0) for x, y in ground.points], _GROUND, 0.02)
    return foxglove.entity(time, WORLD, ground.name, lines=[loop])


def _place(place: Place, time: int) -> foxglove.Json:
    radius = place.radius or 0.1
    ring = [
        (place.x + radius * math.cos(a), place.y + radius * math.sin(a), 0.0) for a in np.linspace(0, 2 * np.pi, 33)
    ]
    text = {
        "pose": foxglove.pose(place.x, place.y, 0.2),
        "billboard": True,
        "font_size": 0.12,
        "scale_invariant": False,
        "color": _PLACE,
        "text": place.name,
    }
    return foxglove.entity(time, WORLD, place.name, lines=[foxglove.line(0, ring, _PLACE, 0.02)], texts=[text])


def _hull(body: BodyInfo, time: int) -> foxglove.Json:
    loops = [foxglove.line(1, [(x, y, z) for x, y in body.hull], _HULL, 0.02) for z in (0.0, body.height)]
    return foxglove.entity(time, body.name, f"{body.name}/hull", lines=loops)


def _json(value: foxglove.Json) -> bytes:
    return msgspec.json.encode(value)
