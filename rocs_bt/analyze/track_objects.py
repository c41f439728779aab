"""TrackObjects: the things around the robot, believed in as far as its ranges show them."""

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
from .analyze import Analyze

MOVED = 0.02
"""A position is written anew when it has moved so far [m]."""

GREW = 0.2
"""So is what else is believed, when it changed by this share of what was written."""

RENEWED = 1.0
"""What is still seen is written anew after so long, for its age [s]."""

MOVING = 0.1
"""What is slower than this counts as standing [m/s]; so does what may well stand, as its speed is not known better."""


STEADY = 1.8
"""In so long what moves changes its velocity by as much as it is [s]."""


@dataclass
class _Written:
    pose: Pose2
    existence: float
    spread: float
    moves: bool
    seen: float


class TrackObjects(Analyze):
    """Keeps an `object` in the graph for each thing that one sensor's beams show, and tells Plan what comes and goes.

    Echoes of neighbouring beams are one thing; what is larger than `largest` is a wall and left to maps. Each thing has
    a position with its covariance, a speed, an existence that grows with sightings, falls when a look that should have
    shown it did not, and decays while nobody looks; where it falls too low the object vanishes. Known peers are left
    out: a robot sensor tells them better. Needs the signals of the ranges and of a PoseMonitor.

    Args:
        ranges: The signal that holds the ranges.
        mounts: Where each beam begins and looks, in the body frame: x [m], y [m], bearing [rad]; neighbours in turn.
            None of a scanner, of which its [[sensor]] table tells.
        half_angle: Of each beam's cone [rad].
        reach: How far they look [m].
        noise: Standard deviation of a range [m].
        largest: What reaches over more than this is no thing [m].
        half_life: After how long unseen its existence is half as sure [s].
        mobility: How fast things are expected to move, as a standard deviation; small for sonars, whose echoes slide
            along what stands still while the robot drives past [m/s].
        peer_radius: Echoes within this of a known peer are its own [m].

    Raises:
        InputError: Neither mounts are given nor a scanner is known, or a size is not positive.
    """

    def __init__(
        self,
        *args: Any,
        ranges: str,
        mounts: Sequence[Sequence[float]] = (),
        half_angle: float = math.radians(15.0),
        reach: float = 1.0,
        noise: float = 0.02,
        largest: float = 0.8,
        half_life: float = 10.0,
        mobility: float = 0.3,
        peer_radius: float = 0.5,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        self._ranges = ranges
        looks = [(float(x), float(y), float(a)) for x, y, a in mounts] or self._of_scanner()
        self._beams = Beams(looks, half_angle, reach, noise, largest)
        self._peer_radius = peer_radius
        settings = BeliefSettings(half_life=half_life, start_speed=mobility, acceleration=mobility**2 / STEADY)
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
        things = self._belief.confirmed
        with self.knowledge.graph.locked():
            for number in seen.vanished:
                del self._written[number]
                if self.knowledge.graph.has(self._node(number)):
                    self.knowledge.graph.remove(self._node(number))
            for number, track in things.items():
                self._write(number, track)
        for number in seen.vanished:
            yield self.change(t, "vanished", self._node(number))
        for number in seen.appeared:
            x, y = things[number].mean[:2].tolist()
            yield self.change(t, "appeared", self._node(number), x=x, y=y)

    def _write(self, number: int, track: Track) -> None:
        graph, node = self.knowledge.graph, self._node(number)
        now, before = _believed(track), self._written.get(number)
        if before is not None and graph.has(node) and not _news(before, now):
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
    unsure = math.sqrt(max(track.covariance[2, 2], track.covariance[3, 3]))
    moves = track.speed > max(MOVING, 2.0 * unsure)
    spread = math.sqrt(max(track.covariance[0, 0], track.covariance[1, 1]))
    return _Written(Pose2(x, y, math.atan2(vy, vx) if moves else 0.0), track.existence, spread, moves, track.seen)


def _news(before: _Written, now: _Written) -> bool:
    """Whether what is believed differs from what was written by so much that it is worth a change."""
    return (
        before.moves is not now.moves
        or before.pose.distance(now.pose) > MOVED
        or abs(now.existence - before.existence) > GREW * before.existence
        or abs(now.spread - before.spread) > GREW * before.spread
        or now.seen - before.seen > RENEWED - 1e-9
    )
