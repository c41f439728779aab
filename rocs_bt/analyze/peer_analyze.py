"""PeerAnalyze: tracks the other robots from noisy range and bearing measurements."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from ..base.errors import Fault, InputError
from ..base.geometry import Pose2, wrap_angle
from ..base.units import PositiveMetres, PositiveRadians, PositiveSeconds
from ..control.motion_filter import MotionFilter, MotionNoise
from ..event import Change
from ..interfaces.channel import Signals, Stamped
from .analyze import Analyze

STATIONARY = 0.08
"""Speed below which a peer counts as stationary, so that its estimated heading is kept [m/s]."""

SURE, CERTAIN = 1.0, 2.0
"""A stationary peer counts as moving if its speed exceeds SURE standard deviations for BEGUN, or CERTAIN once [1].

For robots/summit_xl a stationary peer at 1.5 m exceeds SURE 20 times a minute, and for BEGUN once in six minutes."""

BEGUN = 0.2
"""Time of a speed above SURE after which a peer counts as moving [s]."""

GOES_ON = 0.7
"""Number of standard deviations of its speed below which a moving peer counts as stationary [1]."""

GREW = 0.1
"""Minimum relative change of the standard deviation of a peer's position that is written to the graph [1]."""


@dataclass
class _Track:
    filter: MotionFilter
    seen_at: float  # [s]
    yaw: float  # [rad]
    moves: bool = False
    slow_at: float = -math.inf  # [s] last time with a speed below SURE
    lost: bool = False
    revision: int = 0  # revision of the last written pose
    spread: float = math.nan  # last written spread [m]


class PeerAnalyze(Analyze):
    """Writes pose, speed and turn rate of each peer to the world model, and reports peers that are seen or lost.

    The paper's P3dxPositionAnalyze (6.5), generalised to every robot that the sensor detects. It needs the signals of a
    PeerMonitor and of a PoseMonitor.

    A peer out of view is predicted with its last motion. After `lost_after` it is reported as lost, and the relation
    `sees` ends. After `give_up_after` its pose is cleared. While the peer is out of view, a pose that another source
    writes, such as shared knowledge, is not overwritten.

    Attributes:
        range_noise: Standard deviation of a range [m].
        bearing_noise: Standard deviation of a bearing [rad].
        lost_after: Time out of view after which a peer is lost [s].
        give_up_after: Time out of view after which its pose is unknown [s].

    Raises:
        InputError: lost_after is not below give_up_after.
    """

    range_noise: PositiveMetres = 0.05
    bearing_noise: PositiveRadians = math.radians(2.0)
    lost_after: PositiveSeconds = 0.5
    give_up_after: PositiveSeconds = 3.0

    def __post_init__(self) -> None:
        if not self.lost_after < self.give_up_after:
            found = f"found {self.lost_after:g} s and {self.give_up_after:g} s"
            raise InputError(Fault(f"lost_after of '{self.name}' must be below give_up_after, {found}."))
        self._noise = MotionNoise(range=self.range_noise, bearing=self.bearing_noise)
        self._pose: Pose2 | None = None
        self._tracks: dict[str, _Track] = {}

    def expects(self) -> Sequence[str]:
        return ("pose", "peer_tag", "peer_range", "peer_bearing")

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        # The pose of this period applies, in either order of the two monitors.
        pose = next((s.value["pose"] for s in reversed(samples) if "pose" in s.value), None)
        if pose is not None:
            self._pose = Pose2(*pose) if all(map(math.isfinite, pose)) else None
        for sample in samples:
            if "peer_tag" in sample.value and self._pose is not None:
                yield from self._sighted(sample, self._pose)
        for name in list(self._tracks):
            yield from self._follow(name, samples[-1].t)

    def _sighted(self, sample: Stamped[Signals], pose: Pose2) -> Iterable[Change]:
        names = ("peer_tag", "peer_range", "peer_bearing")
        for tag, distance, bearing in zip(*(sample.value[name] for name in names), strict=True):
            if not tag > 0.0 or not math.isfinite(distance + bearing):
                continue
            name = self._name(int(tag))
            track = self._tracks.get(name)
            if track is None:
                found = MotionFilter(sample.t, pose, distance, bearing, self._noise)
                # Until the peer moves, its heading is assumed to be the direction of observation.
                track = self._tracks[name] = _Track(found, sample.t, wrap_angle(pose.yaw + bearing), lost=True)
            else:
                track.filter.update(sample.t, pose, distance, bearing)
            track.seen_at = sample.t
            if track.lost:
                track.lost = False
                self.knowledge.graph.relate(self.knowledge.agent, "sees", name)
                yield self.change(sample.t, "seen", name, distance=distance, bearing=bearing)

    def _follow(self, name: str, t: float) -> Iterable[Change]:
        track, graph = self._tracks[name], self.knowledge.graph
        unseen = t - track.seen_at
        overwritten = unseen > 0.0 and graph.stamp(name, "pose").revision > track.revision
        if unseen > self.give_up_after:
            del self._tracks[name]
            if not overwritten:
                graph.set(name, pose=None, speed=None, turn_rate=None, spread=None)
            yield self.change(t, "given up", name, unseen=unseen)
            return
        track.filter.predict(t)
        if overwritten:
            track.spread = math.nan  # the graph contains the spread of another source
        else:
            self._write(name, track)
            track.revision = graph.stamp(name, "pose").revision
        if unseen > self.lost_after and not track.lost:
            track.lost = True
            graph.unrelate(self.knowledge.agent, "sees", name)
            yield self.change(t, "lost", name, unseen=unseen)

    def _write(self, name: str, track: _Track) -> None:
        x, y, vx, vy, turn = track.filter.state.tolist()
        speed = math.hypot(vx, vy)
        if _moves(track, speed):
            track.yaw = math.atan2(vy, vx)
        else:
            speed = turn = 0.0
        written: dict[str, Any] = {"pose": Pose2(x, y, track.yaw), "speed": speed, "turn_rate": turn}
        spread = track.filter.spread
        if not abs(spread - track.spread) <= GREW * track.spread:
            track.spread = written["spread"] = spread
        self.knowledge.graph.set(name, **written)

    def _name(self, tag: int) -> str:
        """Name of the peer with a tag; an unknown peer is added as `robot TAG`."""
        graph = self.knowledge.graph
        for name in self.knowledge.world.peers():
            if graph.get(name, "tag") == tag:
                return name
        unknown = f"robot {tag}"
        graph.add(unknown, "peer", tag=tag)
        return unknown


def _moves(track: _Track, speed: float) -> bool:
    """Whether a peer with this estimated speed [m/s] moves; thresholds with hysteresis suppress noise."""
    found = track.filter
    deviation = math.sqrt(max(found.covariance[2, 2], found.covariance[3, 3]))
    if speed <= max(STATIONARY, SURE * deviation):
        track.slow_at = found.t
    if track.moves:
        track.moves = speed > max(STATIONARY, GOES_ON * deviation)
    else:
        track.moves = speed > max(STATIONARY, CERTAIN * deviation) or found.t - track.slow_at > BEGUN
    return track.moves
