"""PeerAnalyze: where the other robots are and how they move, from noisy sightings."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from ..channel import Signals, Stamped
from ..control.motion_filter import MotionFilter, MotionNoise
from ..errors import Fault, InputError
from ..event import Change
from ..geometry import Pose2, wrap_angle
from .analyze import Analyze

STANDING = 0.08
"""A peer that is slower than this counts as standing, and keeps the heading that it had [m/s]."""

SURE, CERTAIN = 1.0, 2.0
"""A standing one moves once it is faster than so many times its speed's standard deviation: for BEGUN, or at once [1].

To robots/summit_xl a peer that stands 1.5 m away exceeds the former 20 times a minute, and so long once in six."""

BEGUN = 0.2
"""How long [s]."""

GOES_ON = 0.7
"""A moving one stands once it is slower than so many times that deviation, or slower than STANDING [1]."""

GREW = 0.1
"""Share of its spread by which a peer's must change to be told anew [1]."""


@dataclass
class _Track:
    filter: MotionFilter
    seen_at: float  # [s]
    yaw: float  # [rad]
    moves: bool = False
    slow_at: float = -math.inf  # [s] when it was last too slow to begin
    lost: bool = False
    revision: int = 0  # of the pose that was written last
    spread: float = math.nan  # that was written last [m]


class PeerAnalyze(Analyze):
    """Keeps each peer's pose, speed and turn rate in the world model, and tells Plan who comes and who goes.

    The paper's P3dxPositionAnalyze (6.5), for every robot that its sensor knows. Needs the signals of a PeerMonitor
    and of a PoseMonitor. A peer that is out of view goes on as it was last seen to move; it is `lost` after a while,
    which changes nothing but that `sees` does not hold, and given up after a longer one: then its pose is not known.
    While it is out of view the word of somebody who tells where it is, as by shared knowledge, stands.

    Args:
        range_noise: Standard deviation of a range [m].
        bearing_noise: Standard deviation of a bearing [rad].
        lost_after: How long a peer may be out of view until it is told as lost [s].
        give_up_after: How long until nobody knows where it is [s].
    """

    def __init__(
        self,
        *args: Any,
        range_noise: float = 0.05,
        bearing_noise: float = math.radians(2.0),
        lost_after: float = 0.5,
        give_up_after: float = 3.0,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        if not (range_noise > 0.0 and bearing_noise > 0.0 and 0.0 < lost_after < give_up_after < math.inf):
            raise InputError(
                Fault(
                    f"'{self.name}' needs range_noise and bearing_noise above 0, and lost_after below give_up_after, "
                    f"found {range_noise} m, {bearing_noise} rad, {lost_after} s and {give_up_after} s."
                )
            )
        self._noise = MotionNoise(range=range_noise, bearing=bearing_noise)
        self._lost_after = lost_after
        self._give_up_after = give_up_after
        self._pose: Pose2 | None = None
        self._tracks: dict[str, _Track] = {}

    def expects(self) -> Sequence[str]:
        return ("pose", "peer_tag", "peer_range", "peer_bearing")

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        # The pose of this period counts, whichever of the two monitors came first.
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
                # Until it moves it is taken to look where the observer looks at it.
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
        told = unseen > 0.0 and graph.stamp(name, "pose").revision > track.revision
        if unseen > self._give_up_after:
            del self._tracks[name]
            if not told:
                graph.set(name, pose=None, speed=None, turn_rate=None, spread=None)
            yield self.change(t, "given up", name, unseen=unseen)
            return
        track.filter.predict(t)
        if told:
            track.spread = math.nan  # what stands there is no longer its own
        else:
            self._write(name, track)
            track.revision = graph.stamp(name, "pose").revision
        if unseen > self._lost_after and not track.lost:
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
        """Who wears a tag; somebody that nobody has told of gets a name of its own."""
        graph = self.knowledge.graph
        for name in self.knowledge.world.peers():
            if graph.get(name, "tag") == tag:
                return name
        stranger = f"robot {tag}"
        graph.add(stranger, "peer", tag=tag)
        return stranger


def _moves(track: _Track, speed: float) -> bool:
    """Whether a peer moves that seems to have this speed [m/s]: a dead band, and what lasts, against noise."""
    found = track.filter
    deviation = math.sqrt(max(found.covariance[2, 2], found.covariance[3, 3]))
    if speed <= max(STANDING, SURE * deviation):
        track.slow_at = found.t
    if track.moves:
        track.moves = speed > max(STANDING, GOES_ON * deviation)
    else:
        track.moves = speed > max(STANDING, CERTAIN * deviation) or found.t - track.slow_at > BEGUN
    return track.moves
