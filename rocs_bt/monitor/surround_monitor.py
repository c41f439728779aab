"""SurroundMonitor: the standard groups of a robot with few beams, from its memory and what it knows of its peers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..channel import Signals
from ..control.ways import BENDS, STRAIGHT, leading_edges
from ..device import Reading
from ..errors import Fault, InputError
from ..geometry import Pose2, along_arc
from ..signal import Signal
from ..units import LENGTH
from .encounter import ASIDE, BEHIND, Encounters
from .local_memory import Array, LocalMemory, Mount
from .range_monitor import RangeMonitor

GROUPS = ("front", "left_gap", "right_gap", "rear")
"""The standard groups: each has one value for the peers and one for the memory after those of its beams."""

ROOMS = {"room_ahead": "on", "room_behind": "back"}
"""Signals that tell how far the robot may drive on each bend, and the word for it."""

SECTORS = ((math.radians(20.0), 1.0), (math.radians(40.0), 0.85), (math.radians(60.0), 0.6))
"""How much counts behind what is so far off the axis [rad]: as with the beams of a ring of sonars."""

_ENDS, _WEIGHTS = np.array(SECTORS).T.copy()

SPARE = 0.3
"""What it leaves to what is ahead [m]."""

STRIDES = np.linspace(0.1, 1.0, 10)
"""How far it looks for free ground, and how fine [m]."""

ROOM = (0.0, *STRIDES.tolist())
"""How far it may drive once so many strides were found to be free [m]."""

BACKING = -0.02
"""Who is faster than this does not drive back [m/s]."""


class SurroundMonitor(RangeMonitor):
    """A RangeMonitor whose standard groups hold what no beam sees now: the nearest peer, and the nearest echo lately.

    So rules that know ranges alone work on a robot with three beams. Needs the body's length and width, and a monitor
    before it that writes `peer_range`.

    *Peers* are those of the world model, where its Analyze has put them: with their speed, and through occlusions. A
    peer's value is the gap between the hulls where it will be least while this robot comes to stand and the peer goes
    on; what closes in counts as nearer, and so does what a corner of a turning hull would sweep. One that comes near
    belongs to the group that a reflex must drive away from: to `rear` if driving ahead leads away from it, to `front`
    if driving back does, and to both if the robot had better stand.

    *Echoes* count as long as the memory lasts, over the weight that a ring's beam has in their direction; those behind
    only while the robot drives back, since what stands still comes no nearer.

    *Ground* is remembered where it was seen to be free. `room_ahead` and `room_behind` tell how far the robot may drive
    on it, one value for each of `control.ways.BENDS` [m]; back it goes nowhere else.

    All groups are invalid as long as the pose, or `peer_range`, is: who cannot see must not drive as if nobody were
    there.

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
        self._memory = LocalMemory([Mount(*mount) for mount in mounts], half_angle, reach, memory, self._half)
        # (5, 2, bends, strides, 2), and in memory x and y apart: so numpy looks them up in two thirds of the time.
        edges = leading_edges(self._half, STRIDES).transpose(4, 3, 0, 1, 2)
        self._edges = np.moveaxis(np.ascontiguousarray(edges), 0, -1)
        self._radius = peer_radius
        self._encounters = Encounters(
            self.knowledge,
            self._half,
            radius=peer_radius,
            reaction=reaction,
            deceleration=deceleration,
            horizon=horizon,
        )

    def signals(self) -> Sequence[Signal]:
        raw, *groups = super().signals()
        bends = ", ".join(f"{bend:g}" for bend in BENDS)
        rooms = [
            Signal(
                name,
                len(BENDS),
                (LENGTH,) * len(BENDS),
                (0.0, float(STRIDES[-1])),
                self.max_age,
                f"How far it may drive {word} on ground that it knows to be free, on bends of {bends} rad/m.",
            )
            for name, word in ROOMS.items()
        ]
        return [raw, *(self._wider(signal) if signal.name in GROUPS else signal for signal in groups), *rooms]

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        written: dict[str, Sequence[float]] = dict(super().interpret(readings))
        knowledge = self.knowledge
        now, world = knowledge.clock.now(), knowledge.world
        pose = knowledge.robot.pose(now)
        blind = any(map(math.isnan, knowledge.signals.read("peer_range", now).tolist()))
        if blind or math.isnan(pose.x + pose.yaw):
            unknown = {name: [*written[name], math.nan, math.nan] for name in GROUPS}
            return {**written, **unknown, **{name: [0.0] * len(BENDS) for name in ROOMS}}
        motions = {peer: (now - m[0], m[1], m[2]) for peer in world.peers() if (m := world.motion_of(peer)) is not None}
        places = [along_arc(place, twist, since) for since, place, twist in motions.values()]
        ranges = next(iter(readings.values())).values
        self._memory.look(now, pose, ranges, places, self._radius)
        self._leave_out(written, self._memory.explained(pose, ranges, places, self._radius))
        ahead, behind = self._rooms(now, pose)
        room = min(ahead[STRAIGHT], min(written["front"]) - SPARE), behind[STRAIGHT]
        peers = self._encounters.groups(pose, motions, now, room)
        echoes = self._echoes(pose, backing=knowledge.robot.speed(now) <= BACKING)
        for name, *values in zip(GROUPS, peers, echoes, strict=True):
            written[name] = [*written[name], *values]
        return {**written, **dict(zip(ROOMS, (ahead, behind), strict=True))}

    def _rooms(self, now: float, pose: Pose2) -> list[list[float]]:
        """How far it may drive on each bend, ahead and back [m]."""
        free = np.logical_and.reduce(self._memory.free(now, pose, self._edges))  # (2, bends, strides)
        return [[ROOM[bend.index(False) if False in bend else -1] for bend in way] for way in free.tolist()]

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

    def _echoes(self, pose: Pose2, *, backing: bool) -> tuple[float, float, float, float]:
        """What the memory adds to each of `GROUPS`; nothing ahead, where the beams look."""
        points = self._memory.around(pose)
        if not len(points):
            return (math.inf,) * 4
        outside = np.maximum(np.abs(points) - self._half, 0.0)
        gaps, bearings = np.hypot(outside[:, 0], outside[:, 1]), np.arctan2(points[:, 1], points[:, 0])
        off = np.abs(bearings)
        beside, to_left = off <= 0.5 * math.pi, bearings >= 0.0
        left = float(gaps[beside & to_left].min(initial=math.inf))
        right = float(gaps[beside & ~to_left].min(initial=math.inf))
        # What lies beside the way is passed, and no reason to flinch; a turn would lead there.
        rear = _along(gaps, math.pi - off)
        return math.inf, max(left, ASIDE), max(right, ASIDE), rear if backing else max(rear, BEHIND)


def _along(gaps: Array, aside: Array) -> float:
    """The least gap [m] over its sector's weight."""
    near = aside <= _ENDS[-1]
    return float((gaps[near] / _WEIGHTS[_ENDS.searchsorted(aside[near])]).min(initial=math.inf))
