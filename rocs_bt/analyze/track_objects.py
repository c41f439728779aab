"""TrackObjects: tracks objects around the robot from range measurements."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from ..channel import Signals, Stamped
from ..event import Change
from ..geometry import Pose2
from ..knowledge.belief import Belief, BeliefSettings, Sighting, Track
from ..knowledge.belief.beams import Beams
from ..units import Metres, MetresPerSecond, Radians, Seconds
from .analyze import Analyze

MOVED = 0.02
"""Minimum change of an object's position that is written to the graph [m]."""

GREW = 0.2
"""Minimum relative change of an object's existence or standard deviation that is written to the graph [1]."""

RENEWED = 1.0
"""Time after which the values of an object in view are written again even if they have not changed [s]."""

MOVING = 0.1
"""Speed below which an object counts as stationary [m/s]; the speed must also exceed two standard deviations."""


STEADY = 1.8
"""Time in which a moving object can change its velocity completely [s]; it sets the process noise."""


@dataclass
class _Written:
    pose: Pose2
    existence: float
    spread: float
    moves: bool
    seen: float


class TrackObjects(Analyze):
    """Keeps an `object` node for each object that one range sensor detects, and reports when objects appear or vanish.

    Echoes of neighbouring beams form one object; larger structures than `max_object_size` are walls, which belong to
    maps. Each object has a position with covariance, a speed, and a probability of existence. The existence grows with
    detections, falls when a scan should have shown the object but did not, and decays while it is out of view. An
    object with a low existence is removed. Known peers are excluded, because a robot sensor measures them better. The
    analyser needs the signal of the ranges and the signals of a PoseMonitor.

    Args:
        ranges: Name of the signal with the ranges.
        mounts: Origin and direction of each beam, body frame: x [m], y [m], bearing [rad]; neighbours in order. Omit it
            for a scanner: its [[sensor]] table declares the mount.
        half_angle: Half the opening angle of each beam [rad].
        max_range: Maximum range [m].
        noise: Standard deviation of a range [m].
        max_object_size: Maximum size of an object [m].
        half_life: Time out of view in which the existence is halved [s].
        speed_noise: Standard deviation of the expected speeds [m/s]; small for sonars, because their echoes slide along
            stationary objects while the robot drives past.
        peer_radius: Distance from a known peer within which echoes are ignored [m].

    Raises:
        InputError: No mounts are given and no scanner is known, or a size is not positive.
    """

    def __init__(
        self,
        *args: Any,
        ranges: str,
        mounts: Sequence[tuple[Metres, Metres, Radians]] = (),
        half_angle: Radians = math.radians(15.0),
        max_range: Metres = 1.0,
        noise: Metres = 0.02,
        max_object_size: Metres = 0.8,
        half_life: Seconds = 10.0,
        speed_noise: MetresPerSecond = 0.3,
        peer_radius: Metres = 0.5,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        self._ranges = ranges
        looks = [(float(x), float(y), float(a)) for x, y, a in mounts] or self._of_scanner()
        self._beams = Beams(looks, half_angle, max_range, noise, max_object_size)
        self._peer_radius = peer_radius
        settings = BeliefSettings(half_life=half_life, start_speed=speed_noise, acceleration=speed_noise**2 / STEADY)
        self._belief = Belief(settings)
        self._pose: Pose2 | None = None
        self._written: dict[int, _Written] = {}

    def expects(self) -> Sequence[str]:
        return (self._ranges, "pose")

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        # The pose of this period counts, whichever of the two monitors came first.
        pose = next((s.value["pose"] for s in reversed(samples) if "pose" in s.value), None)
        if pose is not None:
            self._pose = Pose2(*pose) if all(map(math.isfinite, pose)) else None
        for sample in samples:
            if self._ranges in sample.value and self._pose is not None:
                yield from self._look(sample.t, self._pose, sample.value[self._ranges])

    def _look(self, t: float, pose: Pose2, ranges: Sequence[float]) -> Iterable[Change]:
        beams = self._beams
        sightings = [s for s in beams.sightings(pose, ranges) if not self._is_peer(s)]
        seen = self._belief.update(t, sightings, lambda track: beams.in_view(pose, ranges, track))
        tracks = self._belief.confirmed
        with self.knowledge.graph.locked():
            for number in seen.vanished:
                del self._written[number]
                if self.knowledge.graph.has(self._node(number)):
                    self.knowledge.graph.remove(self._node(number))
            for number, track in tracks.items():
                self._write(number, track)
        for number in seen.vanished:
            yield self.change(t, "vanished", self._node(number))
        for number in seen.appeared:
            x, y = tracks[number].mean[:2].tolist()
            yield self.change(t, "appeared", self._node(number), x=x, y=y)

    def _write(self, number: int, track: Track) -> None:
        graph, node = self.knowledge.graph, self._node(number)
        now, before = _believed(track), self._written.get(number)
        if before is not None and graph.has(node) and not _changed(before, now):
            return
        self._written[number] = now
        values = {
            "pose": now.pose,
            "covariance": tuple(track.covariance[:2, :2].ravel().tolist()),
            "existence": now.existence,
            "radius": track.radius,
            "moves": now.moves,
            "speed": track.speed,
            "seen": track.seen,
        }
        if graph.has(node):
            graph.set(node, **values)
        else:
            graph.add(node, "object", **values)
            for sensor in self._sensors():
                graph.relate(node, "sensed_by", sensor)

    def _node(self, number: int) -> str:
        return f"{self.name}_{number}"

    def _sensors(self) -> list[str]:
        graph = self.knowledge.graph
        return [s for s in graph.related(graph.agent, "has_sensor") if graph.get(s, "signal") in (self._ranges, s)][:1]

    def _is_peer(self, sighting: Sighting) -> bool:
        world = self.knowledge.world
        poses = [world.pose_of(peer) for peer in world.peers()]
        x, y = sighting.position.tolist()
        return any(pose is not None and math.dist(pose[:2], (x, y)) < self._peer_radius for pose in poses)

    def _of_scanner(self) -> list[tuple[float, float, float]]:
        scanner = self.knowledge.robot.scanner(self._ranges)
        x, y, yaw = scanner.mount
        return [(x, y, yaw + bearing) for bearing in scanner.bearings.tolist()]


def _believed(track: Track) -> _Written:
    x, y, vx, vy = track.mean.tolist()
    deviation = math.sqrt(max(track.covariance[2, 2], track.covariance[3, 3]))
    moves = track.speed > max(MOVING, 2.0 * deviation)
    spread = math.sqrt(max(track.covariance[0, 0], track.covariance[1, 1]))
    return _Written(Pose2(x, y, math.atan2(vy, vx) if moves else 0.0), track.existence, spread, moves, track.seen)


def _changed(before: _Written, now: _Written) -> bool:
    """Whether the estimate differs enough from the written values to be written again."""
    return (
        before.moves is not now.moves
        or before.pose.distance(now.pose) > MOVED
        or abs(now.existence - before.existence) > GREW * before.existence
        or abs(now.spread - before.spread) > GREW * before.spread
        or now.seen - before.seen > RENEWED - 1e-9
    )
