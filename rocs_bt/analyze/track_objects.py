"""TrackObjects: tracks the objects around the robot from range measurements, and predicts those that move."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ..base.geometry import Pose2
from ..base.signal import Signal
from ..base.units import LENGTH, TIME, Metres, MetresPerSecond, MetresPerSecondSquared, Radians, Seconds
from ..control.footprint import Footprint
from ..control.locomotion import Array
from ..control.tracking import Beams, MotionBelief, Scan, Segments, Tracker, TrackerSettings, segments_of
from ..event import Change
from ..interfaces.channel import Signals, Stamped
from ..knowledge import Movers
from .analyze import Analyze
from .pose_history import PoseHistory

COLLISION, CLEARANCE = "collision_time", "predicted_clearance"
"""Names of the signals with the time until the hull touches a mover [s], and the smallest gap to one until then [m]."""

WRITE_EVERY = 0.5
"""Minimum time between two writes of an object's values to the graph [s]."""

MOVED = 0.02
"""Minimum change of an object's position that is written to the graph [m]."""

GREW = 0.2
"""Minimum relative change of an object's existence or standard deviation that is written to the graph [1]."""

RENEWED = 1.0
"""Time after which the values of an object in view are written again even if they have not changed [s]."""


@dataclass
class _Written:
    t: float
    pose: Pose2
    existence: float
    spread: float
    moves: bool
    seen: float


class TrackObjects(Analyze):
    """Tracks the objects that one range sensor detects: `object` nodes in the graph, and `knowledge.world.movers`.

    Echoes of neighbouring beams form one object; larger structures than `max_object_size` are walls, which belong to
    maps. Each object has a position with covariance, a speed, and a probability of existence. The existence grows with
    detections, falls when a scan looks past the place of the object, and decays while it is out of view. An object with
    a low existence is removed. Known peers are excluded, because a robot sensor measures them better. The analyser
    needs the signal of the ranges and the signals of a PoseMonitor.

    With a scanner it also replaces `knowledge.world.movers` at each scan. At each new pose it writes two signals, for
    the present time and twist of the robot, however old the scan is: `collision_time` [s], until the hull touches a
    mover, and `predicted_clearance` [m], the smallest gap to a mover within `horizon`. Both are +inf without movers,
    NaN while a beam is NaN or the robot's speed is unknown, and valid as long as the scan.

    Attributes:
        ranges: Name of the signal with the ranges.
        mounts: Origin and direction of each beam, body frame: x [m], y [m], bearing [rad]; neighbours in order. Omit it
            for a scanner: its [[sensor]] table declares the mount.
        half_angle: Half the opening angle of each beam [rad]; None for half the angle between a scanner's beams.
        max_range: Maximum range [m].
        noise: Standard deviation of a range [m].
        sweep: Time from the first beam of a scan to the last [s].
        max_object_size: Maximum size of an object [m].
        static_objects: Whether the graph also gets the objects that do not move.
        half_life: Time out of view in which the existence is halved [s].
        memory: Time out of view after which an object that has moved is forgotten [s].
        acceleration: Standard deviation of the acceleration of objects [m/s2].
        speed_noise: Standard deviation of the expected speeds [m/s]; small for sonars, because their echoes slide along
            stationary objects while the robot drives past.
        min_speed: Speed below which an object counts as standing [m/s].
        peer_radius: Distance from a known peer within which echoes are ignored [m].
        horizon: Time ahead for which the signals predict [s].

    Raises:
        InputError: No mounts are given and no scanner is known, or a size is not positive.
    """

    before_reflexes = True

    ranges: str
    mounts: tuple[tuple[Metres, Metres, Radians], ...] = ()
    half_angle: Radians | None = None
    max_range: Metres = 1.0
    noise: Metres = 0.02
    sweep: Seconds = 0.0
    max_object_size: Metres = 0.9
    static_objects: bool = True
    half_life: Seconds = 10.0
    memory: Seconds = 2.0
    acceleration: MetresPerSecondSquared = 1.5
    speed_noise: MetresPerSecond = 1.0
    min_speed: MetresPerSecond = 0.15
    peer_radius: Metres = 0.5
    horizon: Seconds = 3.0

    def __post_init__(self) -> None:
        self._scanner = not self.mounts
        looks = [(float(x), float(y), float(a)) for x, y, a in self.mounts] or self._of_scanner()
        wide = math.radians(15.0) if self.mounts else 0.5 * abs(looks[-1][2] - looks[0][2]) / max(len(looks) - 1, 1)
        half_angle = wide if self.half_angle is None else self.half_angle
        self._beams = Beams(looks, half_angle, self.max_range, self.noise, self.sweep)
        settings = self.acceleration, self.speed_noise, self.min_speed, self.half_life, self.memory
        self._tracker = Tracker(TrackerSettings(*settings))
        self._hull = self.knowledge.robot.hull
        self._poses, self._motion = PoseHistory(), MotionBelief()
        self._seen, self._broken = -math.inf, False  # [s] time of the newest scan, and whether a beam of it is NaN
        self._written: dict[int, _Written] = {}

    def expects(self) -> Sequence[str]:
        return (self.ranges, "pose")

    def signals(self) -> Sequence[Signal]:
        if not self._scanner or self._hull is None:
            return []
        signals = self.knowledge.signals  # the ranges are declared before the analysers' signals
        age = signals.spec(self.ranges).max_age if self.ranges in signals else math.inf
        docs = "Time until the hull touches what moves; +inf if not soon.", "Smallest predicted gap to what moves."
        return [
            Signal(COLLISION, 1, (TIME,), (0.0, math.inf), age, docs[0]),
            Signal(CLEARANCE, 1, (LENGTH,), (-math.inf, math.inf), age, docs[1]),
        ]

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        # The pose of this period counts, whichever of the two monitors came first.
        self._poses.take(samples)
        for sample in samples:
            if self.ranges not in sample.value or sample.t == self._seen:  # the same scan again: the next one is late
                continue
            self._seen = sample.t
            pose, sweep = self._poses.at(sample.t), self._beams.sweep > 0.0
            poses = self._poses.along(sample.t + self._beams.offsets) if sweep else pose
            if pose is None or poses is None:
                continue
            ranges = np.array(sample.value[self.ranges], float)
            yield from self._look(sample.t, self._beams.scan(poses, ranges))
            if self._scanner:
                self._note_movers(sample.t)
                self._broken = bool(np.isnan(ranges).any())
        movers = self.knowledge.world.movers
        if self._scanner and self._hull is not None and movers is not None:
            self._predict(movers, self._hull)

    def _look(self, t: float, scan: Scan) -> Iterable[Change]:
        found = segments_of(scan, self.max_object_size)
        self._tracker.update(t, found.taken(~self._near_peers(found)))
        tracks, graph = self._tracker.tracks, self.knowledge.graph
        reported = np.flatnonzero(tracks.confirmed & (tracks.movers(t) | self.static_objects))
        numbers = tracks.ids[reported].tolist()
        vanished = sorted(set(self._written).difference(numbers))
        appeared = [(n, i) for n, i in zip(numbers, reported.tolist(), strict=True) if n not in self._written]
        with graph.locked():
            for number in vanished:
                del self._written[number]
                if graph.has(self._node(number)):
                    graph.remove(self._node(number))
            for number, i in zip(numbers, reported.tolist(), strict=True):
                self._write(t, number, i)
        for number in vanished:
            yield self.change(t, "vanished", self._node(number))
        for number, i in appeared:
            x, y = tracks.mean[i, :2].tolist()
            yield self.change(t, "appeared", self._node(number), x=x, y=y)

    def _note_movers(self, t: float) -> None:
        """Replace the movers by those of a scan."""
        tracks, world = self._tracker.tracks, self.knowledge.world
        chosen = tracks.taken(tracks.confirmed & tracks.movers(t))
        motion = self._motion.update(t, chosen.ids, chosen.mean)
        tracked = Movers(
            t=t,
            ids=chosen.ids,
            mean=chosen.mean,
            covariance=chosen.covariance,
            radius=chosen.radius,
            seen=chosen.seen,
            moves=chosen.fast(self._tracker.settings.min_speed),
            **motion._asdict(),
        )
        world.movers = tracked if world.foreseen is None else world.foreseen

    def _predict(self, movers: Movers, hull: Footprint) -> None:
        """Write the signals of the coming seconds, as of now: from the last scan and the present pose and twist."""
        now = self.now(movers.t)
        twist = self.knowledge.robot.twist(now)
        if (pose := self._poses.present(now, twist)) is None:
            return
        known = not self._broken and not math.isnan(twist.forward + twist.left + twist.turn)
        collision = clearance = math.inf if known else math.nan
        if known and len(movers):
            ahead = movers.predict(now + np.linspace(0.0, self.horizon, 7))
            collision, clearance = ahead.contact(hull, pose, twist)
        self.write(movers.t, {COLLISION: [collision], CLEARANCE: [clearance]})

    def _write(self, t: float, number: int, index: int) -> None:
        graph, node, tracks = self.knowledge.graph, self._node(number), self._tracker.tracks
        before, there = self._written.get(number), graph.has(node)
        if before is not None and there and t - before.t < WRITE_EVERY - 1e-9:
            return
        now = self._believed(t, index)
        if before is not None and there and not _changed(before, now):
            return
        self._written[number] = now
        values = {
            "pose": now.pose,
            "covariance": tuple(tracks.covariance[index, :2, :2].ravel().tolist()),
            "existence": now.existence,
            "radius": float(tracks.radius[index]),
            "moves": now.moves,
            "speed": float(tracks.speed[index]),
            "seen": now.seen,
        }
        if there:
            graph.set(node, **values)
        else:
            graph.add(node, "object", **values)
            for sensor in self._sensors():
                graph.relate(node, "sensed_by", sensor)

    def _believed(self, t: float, index: int) -> _Written:
        tracks = self._tracker.tracks
        x, y, vx, vy = tracks.mean[index].tolist()
        moves = bool((tracks.movers(t) & tracks.fast(self._tracker.settings.min_speed))[index])
        spread = math.sqrt(max(tracks.covariance[index, 0, 0], tracks.covariance[index, 1, 1]))
        pose = Pose2(x, y, math.atan2(vy, vx) if moves else 0.0)
        return _Written(t, pose, float(tracks.existence[index]), spread, moves, float(tracks.seen[index]))

    def _node(self, number: int) -> str:
        return f"{self.name}_{number}"

    def _sensors(self) -> list[str]:
        graph = self.knowledge.graph
        return [s for s in graph.related(graph.agent, "has_sensor") if graph.get(s, "signal") in (self.ranges, s)][:1]

    def _near_peers(self, segments: Segments) -> npt.NDArray[np.bool_]:
        """Whether each segment is part of a known peer, shape (s,)."""
        world = self.knowledge.world
        poses = [pose for peer in world.peers() if (pose := world.pose_of(peer)) is not None]
        at: Array = np.array([pose[:2] for pose in poses]).reshape(-1, 2)
        dx, dy = (segments.centre[:, None] - at).transpose(2, 0, 1)
        near: npt.NDArray[np.bool_] = (np.hypot(dx, dy) < self.peer_radius).any(axis=1)
        return near

    def _of_scanner(self) -> list[tuple[float, float, float]]:
        scanner = self.knowledge.robot.scanner(self.ranges)
        x, y, yaw = scanner.mount
        return [(x, y, yaw + bearing) for bearing in scanner.bearings.tolist()]


def _changed(before: _Written, now: _Written) -> bool:
    """Whether the estimate differs enough from the written values to be written again."""
    return (
        before.moves is not now.moves
        or before.pose.distance(now.pose) > MOVED
        or abs(now.existence - before.existence) > GREW * before.existence
        or abs(now.spread - before.spread) > GREW * before.spread
        or now.seen - before.seen > RENEWED - 1e-9
    )
