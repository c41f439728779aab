"""SurroundMonitor: the standard groups of a robot with few beams, from its memory and what it knows of its peers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ..channel import Signals
from ..device import Reading
from ..errors import Fault, InputError
from ..geometry import Pose2, Twist2, along_arc
from ..signal import Signal
from .local_memory import LocalMemory, Mount
from .range_monitor import RangeMonitor

GROUPS = ("front", "left_gap", "right_gap", "rear")
"""The standard groups: each has one value for the peers and one for the memory after those of its beams."""

SECTORS = ((math.radians(20.0), 1.0), (math.radians(40.0), 0.85), (math.radians(60.0), 0.6))
"""How much counts to the front, or behind, what is so far off the axis [rad]: as with the beams of a ring of sonars."""

STEP = 0.1
"""Time between two looks ahead at a peer [s]."""

NEAR = 0.2
"""Gap to a peer below which the robot must go from it, or stand [m]."""

TOUCH = 0.05
"""Gap that a way off must keep, or it is none [m]."""

AWAY = 0.35
"""Speed at which it would go [m/s]."""

SLOW = 0.15
"""Time lost until it is that fast [s]."""

FAR = (0.1, 0.4, 0.8, 1.2)
"""When it looks how that came out [s]."""

SURE = 0.08
"""By so much it keeps more than the safety distance, since it only estimates where its leader is [m]."""

DUTY = 15.0
"""For so long it keeps its distance after it was told to follow [s]: a reflex interrupts the one, not the other."""

PINNED = 1.5
"""Who was all but touched for so long goes wherever it comes no nearer than if it stood [s]."""

ROOM = 0.4
"""What must be free ahead, or behind, for that [m]."""

KNOWN = 0.25
"""As near to where it was lately nothing is in the way [m]."""

Motion = tuple[float, Pose2, Twist2]
"""How a peer moves: since how long [s], from where, and how fast."""


class Gap(NamedTuple):
    """How near a peer comes in the next moments."""

    least: float  # [m] from hull to hull, where that is least
    bearing: float  # [rad] of the peer's centre at that moment, left positive
    distance: float  # [m] the least between the centres


class SurroundMonitor(RangeMonitor):
    """A RangeMonitor whose standard groups hold what no beam sees now: the nearest peer, and the nearest echo lately.

    So rules that know ranges alone work on a robot with three beams. Needs the body's length and width, and a monitor
    before it that writes `peer_range`.

    *Peers* are those of the world model, where its Analyze has put them: with their speed, and through occlusions. A
    peer's value is the gap between the hulls where it will be least while this robot comes to stand and the peer goes
    on; what closes in counts as nearer, and so does what a corner of a turning hull would sweep. One that comes near
    belongs to the group that a reflex must drive away from: to `rear` if driving ahead leads away from it, to its
    side's gap if driving back does, and to `front` and `rear` both if the robot had better stand.

    *Echoes* count as long as the memory lasts, over the weight that a ring's beam has in their direction. While
    something is near ahead, a way back on which the robot has not been lately counts as blocked.

    All are invalid as long as the pose, or `peer_range`, is: who cannot see must not drive as if nobody were there.

    Args:
        mounts: x [m], y [m] and yaw [rad] of each beam, in the body frame.
        half_angle: Of a beam's cone [rad].
        reach: Of the beams [m].
        memory: How long an echo is remembered [s].
        peer_radius: Of a circle around a peer's base that holds its hull [m].
        reaction: From a reading to wheels that begin to brake [s].
        deceleration: Of braking wheels [m/s2].
        horizon: How far to look ahead at least [s].
    """

    def __init__(
        self,
        *args: Any,
        mounts: Sequence[Sequence[float]],
        half_angle: float,
        reach: float,
        memory: float,
        peer_radius: float,
        reaction: float,
        deceleration: float,
        horizon: float = 0.7,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        numbers = (half_angle, reach, memory, peer_radius, reaction, deceleration, horizon)
        if not all(0.0 < value < math.inf for value in numbers):
            raise InputError(
                Fault(f"the numbers of monitor '{self.name}' must be above 0 and finite, found {numbers}.")
            )
        if missed := [name for name in GROUPS if name not in self._groups]:
            raise InputError(
                Fault(f"monitor '{self.name}' needs the groups {', '.join(GROUPS)}; {missed} are missing.")
            )
        if len(mounts) != self._beams or any(len(mount) != 3 for mount in mounts):
            raise InputError(Fault(f"mounts of monitor '{self.name}' must be x, y and yaw of {self._beams} beams."))
        body = self.knowledge.graph.attributes(self.knowledge.agent)
        if not (body.get("length") and body.get("width")):
            raise InputError(Fault(f"monitor '{self.name}' needs the robot's length and width in its [body] table."))
        self._half = 0.5 * body["length"], 0.5 * body["width"]
        self._memory = LocalMemory([Mount(*mount) for mount in mounts], half_angle, reach, memory)
        self._radius = peer_radius
        self._reaction = reaction
        self._deceleration = deceleration
        self._horizon = horizon
        self._pinned = math.inf  # since when somebody touches it, or all but [s]
        self._duty = (-math.inf, "", 0.0, 0.0)  # until when [s], to keep what distance from whom

    def signals(self) -> Sequence[Signal]:
        raw, *groups = super().signals()
        return [raw, *(self._wider(signal) if signal.name in GROUPS else signal for signal in groups)]

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        written: dict[str, Sequence[float]] = dict(super().interpret(readings))
        knowledge = self.knowledge
        now, world = knowledge.clock.now(), knowledge.world
        pose = knowledge.robot.pose(now)
        blind = bool(np.isnan(knowledge.signals.read("peer_range", now)).any())
        if blind or math.isnan(pose.x + pose.yaw):
            return {**written, **{name: [*written[name], math.nan, math.nan] for name in GROUPS}}
        motions = {peer: (now - m[0], m[1], m[2]) for peer in world.peers() if (m := world.motion_of(peer)) is not None}
        places = [along_arc(place, twist, since) for since, place, twist in motions.values()]
        ranges = next(iter(readings.values())).values
        self._memory.look(now, pose, ranges, places, self._radius)
        self._leave_out(written, self._memory.explained(pose, ranges, places, self._radius))
        echoes = self._echoes(pose)
        peers = self._peers(pose, motions, now, (min(written["front"]), echoes[3])) if motions else (math.inf,) * 4
        for name, *values in zip(GROUPS, peers, echoes, strict=True):
            written[name] = [*written[name], *values]
        return written

    def _wider(self, signal: Signal) -> Signal:
        doc = f"{signal.doc} Then the nearest peer, and the nearest echo lately."
        size = signal.size + 2
        return replace(signal, size=size, dimensions=signal.dimensions[:1] * size, doc=doc)

    def _leave_out(self, written: dict[str, Sequence[float]], explained: Sequence[bool]) -> None:
        """Take the echoes of peers out of the groups: what is known of a peer says more than its echo."""
        if any(explained):
            for name, group in self._groups.items():
                beams = zip(group.beams, written[name], strict=False)
                written[name] = [math.inf if explained[beam] else value for beam, value in beams] or written[name]

    def _echoes(self, pose: Pose2) -> tuple[float, float, float, float]:
        """What the memory adds to each of `GROUPS`; nothing ahead, where the beams look."""
        points = self._memory.around(pose)
        if not len(points):
            return (math.inf,) * 4
        outside = np.maximum(np.abs(points) - self._half, 0.0)
        gaps, bearings = np.hypot(outside[:, 0], outside[:, 1]), np.arctan2(points[:, 1], points[:, 0])
        beside = np.abs(bearings) <= 0.5 * math.pi
        left = float(gaps[beside & (bearings >= 0.0)].min(initial=math.inf))
        right = float(gaps[beside & (bearings < 0.0)].min(initial=math.inf))
        # What lies beside the way is passed, and no reason to flinch; a turn would lead there.
        return math.inf, max(left, 0.22), max(right, 0.22), _along(gaps, math.pi - np.abs(bearings))

    def _peers(
        self, pose: Pose2, motions: Mapping[str, Motion], now: float, room: tuple[float, float]
    ) -> tuple[float, float, float, float]:
        """What the peers add to each of `GROUPS`, with so much room ahead and behind [m]."""
        way = list(self._way(pose, now))
        gaps = {name: self._gap(way, motion) for name, motion in motions.items()}
        left = min((g.least for g in gaps.values() if 0.0 <= g.bearing <= 0.5 * math.pi), default=math.inf)
        right = min((g.least for g in gaps.values() if -0.5 * math.pi <= g.bearing < 0.0), default=math.inf)
        rear = min((g.least for g in gaps.values() if abs(g.bearing) > 0.5 * math.pi), default=math.inf)
        left, right, rear = max(left, 0.22), max(right, 0.22), max(rear, 0.27)
        if self._must_stand(gaps):
            return TOUCH, left, right, TOUCH
        least = min(g.least for g in gaps.values())
        if least >= NEAR:
            return math.inf, left, right, rear
        escape = self._escape(pose, motions, room)
        return (math.inf if escape > 0 else least), left, right, (rear if escape < 0 else least)

    def _must_stand(self, gaps: Mapping[str, Gap]) -> bool:
        """Whether the robot would come nearer to whom it follows than it may."""
        return any(
            name in gaps and gaps[name].distance < safety + SURE for name, _, safety in self._followed() if safety
        )

    def _followed(self) -> Iterator[tuple[str, float, float]]:
        """Whom the robot follows, at which distance, and nearer than what it must not drive [m]."""
        agent, graph, now = self.knowledge.agent, self.knowledge.graph, self.knowledge.clock.now()
        for name in graph.related(agent, "follows"):
            edge = graph.edge(agent, "follows", name) or {}
            self._duty = now + DUTY, name, edge.get("distance", 0.0), edge.get("safety", 0.0)
        if self._duty[0] > now:
            yield self._duty[1:]

    def _escape(self, pose: Pose2, motions: Mapping[str, Motion], room: tuple[float, float]) -> int:
        """Where to go from peers that come near: 1 ahead, -1 back, 0 nowhere."""
        ways = {name: [along_arc(m[1], m[2], m[0] + t) for t in FAR] for name, m in motions.items()}
        kept = [(ways[name], distance) for name, distance, _ in self._followed() if name in ways]

        def course(speed: float) -> list[float]:
            mine = [along_arc(pose, Twist2(speed), t - SLOW) for t in FAR]
            if any(pose.distance(way[-1]) > mine[-1].distance(way[-1]) < least for way, least in kept):
                return [-1.0] * len(FAR)  # out of one's way into that of whom it follows
            return [min(self._apart(here, way[k]) for way in ways.values()) for k, here in enumerate(mine)]

        stand, now = course(0.0), self.knowledge.clock.now()
        self._pinned = min(self._pinned, now) if stand[0] < TOUCH else math.inf
        least = [gap - 0.01 for gap in stand] if now - self._pinned > PINNED else [TOUCH] * len(FAR)
        open_back = room[1] > ROOM and self._memory.been(along_arc(pose, Twist2(-ROOM), 1.0), KNOWN)
        courses = {sign: course(sign * AWAY) for sign, is_open in ((1, room[0] > ROOM), (-1, open_back)) if is_open}
        good = {
            sign: gaps[-1]
            for sign, gaps in courses.items()
            if gaps[-1] > stand[-1] + TOUCH and all(gap >= low for gap, low in zip(gaps, least, strict=True))
        }
        return max(good, key=lambda sign: good[sign], default=0)

    def _way(self, pose: Pose2, now: float) -> Iterator[tuple[float, Pose2]]:
        """Where the robot is in the next moments, by time from now on [s], if it brakes as soon as it can."""
        robot = self.knowledge.robot
        twist = Twist2(robot.speed(now), robot.turn_rate(now))
        if math.isnan(twist.forward + twist.turn):
            twist = Twist2(0.0)
        rim = max(map(abs, robot.drive.wheel_speeds(twist).tolist()))
        braking = rim / self._deceleration
        horizon = max(self._horizon, self._reaction + braking)
        for i in range(math.ceil(horizon / STEP - 1e-9) + 1):
            t = i * STEP
            slow = min(max(t - self._reaction, 0.0), braking)
            driven = min(t, self._reaction) + (slow - 0.5 * slow * slow / braking if braking > 0.0 else 0.0)
            yield t, along_arc(pose, twist, driven)

    def _gap(self, way: Sequence[tuple[float, Pose2]], motion: Motion) -> Gap:
        """How near a peer comes in the next moments."""
        since, place, twist = motion
        found = []
        for ahead, mine in way:
            other = along_arc(place, twist, since + ahead)
            found.append((self._apart(mine, other), mine.bearing(other), mine.distance(other)))
        return Gap(*min(found)[:2], min(distance for *_, distance in found))

    def _apart(self, pose: Pose2, other: Pose2) -> float:
        """Between the hull, a rectangle, and a peer's circle [m]; no less than zero."""
        c, s = math.cos(pose.yaw), math.sin(pose.yaw)
        dx, dy = other.x - pose.x, other.y - pose.y
        ahead, aside = abs(c * dx + s * dy) - self._half[0], abs(c * dy - s * dx) - self._half[1]
        return max(0.0, math.hypot(max(ahead, 0.0), max(aside, 0.0)) - self._radius)


def _along(gaps: np.ndarray[Any, Any], aside: np.ndarray[Any, Any]) -> float:
    """The least gap [m] over its sector's weight."""
    least, inner = math.inf, -1.0
    for angle, weight in SECTORS:
        least = min(least, float(gaps[(aside > inner) & (aside <= angle)].min(initial=math.inf)) / weight)
        inner = angle
    return least
