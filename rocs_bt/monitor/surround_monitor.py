"""SurroundMonitor: the standard groups of a robot with few beams, from its memory and what it knows of its peers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..channel import Signals
from ..control.arcs import BENDS, HEADINGS, leading_edges, turned_edges
from ..device import Reading
from ..errors import Fault, InputError
from ..geometry import Pose2, along_arc
from ..signal import Signal
from ..units import ANGLE, LENGTH
from .encounter import PASSED, Encounters, Reach
from .gaps import free_turns, least_gaps
from .local_memory import Array, LocalMemory, Mount
from .range_monitor import RangeMonitor

GROUPS = ("front", "left_gap", "right_gap", "rear")
"""The standard groups: each has one value for the peers and one for the memory after those of its beams."""

ROOMS = {
    "room_ahead": (len(BENDS), f"on, on bends of {', '.join(f'{bend:g}' for bend in BENDS)} rad/m"),
    "room_behind": (len(BENDS), "back, on the same bends"),
    "room_turned": (
        len(HEADINGS),
        f"to {len(HEADINGS)} headings of the world, from west by south, once turned there on the spot",
    ),
}
"""Signals that tell how far the robot may drive: how many values each has, and the words for them."""

SECTORS = ((math.radians(20.0), 1.0), (math.radians(40.0), 0.85), (math.radians(60.0), 0.6))
"""How much counts behind what is so far off the axis [rad]: as with the beams of a ring of sonars."""

_SECTORS = np.array(SECTORS)

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
    on it, one value for each of `control.arcs.BENDS` [m]; back it goes nowhere else, and a square of the memory less,
    since no beam sees what else is in a square that the hull was over in part. `room_turned` tells the same for a
    robot that turns on the spot first, one value for each of `control.arcs.HEADINGS`: none where a corner would sweep
    what it does not know. From a peer it drives only over what was seen as lately as an echo.

    `free_turn` tells how far it may turn on the spot, left and right, before a corner comes to where an echo was; these
    it remembers for as long as free ground, since the walls stay where they are.

    All groups are invalid as long as the pose, or `peer_range`, is: who cannot see must not drive as if nobody were
    there.

    Args:
        mounts: x [m], y [m] and yaw [rad] of each beam, in the body frame.
        half_angle: Of a beam's cone [rad].
        reach: Of the beams [m].
        memory: How long an echo is remembered [s].
        ground: How long it is remembered that ground was free [s].
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
        ground: float,
        peer_radius: float,
        reaction: float,
        deceleration: float,
        horizon: float = 0.7,
        **kwargs: Any,
    ) -> None:
        super().__init__(*args, **kwargs)
        numbers = (half_angle, reach, memory, ground, peer_radius, reaction, deceleration, horizon)
        if not all(0.0 < value < math.inf for value in numbers):
            raise InputError(
                Fault(f"the numbers of monitor '{self.name}' must be above 0 and finite, found {numbers}.")
            )
        if ground < memory:
            found = f"found {ground:g} s and {memory:g} s"
            raise InputError(
                Fault(f"ground of monitor '{self.name}' must be remembered at least as long as memory, {found}.")
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
        self._memory = LocalMemory([Mount(*mount) for mount in mounts], half_angle, reach, ground, self._half)
        self._span, self._ground = memory, ground
        self._edges = leading_edges(self._half, STRIDES).reshape(2 * len(BENDS), len(STRIDES), -1, 2)
        self._turned = turned_edges(self._half, STRIDES)
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
        rooms = [
            Signal(
                name,
                size,
                (LENGTH,) * size,
                (0.0, float(STRIDES[-1])),
                self.max_age,
                f"How far it may drive {words}, on ground that it knows to be free.",
            )
            for name, (size, words) in ROOMS.items()
        ]
        doc = "On which bend it goes off from a peer that comes near, ahead and back."
        off = Signal("bend_off", 2, (ANGLE / LENGTH,) * 2, (min(BENDS), max(BENDS)), self.max_age, doc)
        doc = "How far it may turn on the spot, left and right, before a corner comes to where an echo was."
        turn = Signal("free_turn", 2, (ANGLE,) * 2, (0.0, math.pi), self.max_age, doc)
        wider = (self._wider(signal) if signal.name in GROUPS else signal for signal in groups)
        return [raw, *wider, *rooms, turn, off]  # in the order in which they are written: that takes half the time

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        written: dict[str, Sequence[float]] = dict(super().interpret(readings))
        knowledge = self.knowledge
        now, world = knowledge.clock.now(), knowledge.world
        pose = knowledge.robot.pose(now)
        blind = any(map(math.isnan, knowledge.signals.numbers("peer_range", now)))
        if blind or math.isnan(pose.x + pose.yaw):
            unknown = {name: [*written[name], math.nan, math.nan] for name in GROUPS}
            rooms = {name: [0.0] * size for name, (size, _) in ROOMS.items()}
            return {**written, **unknown, **rooms, "free_turn": [math.nan, math.nan], "bend_off": [0.0, 0.0]}
        motions = {peer: (now - m[0], m[1], m[2]) for peer in world.peers() if (m := world.motion_of(peer)) is not None}
        places = [along_arc(place, twist, since) for since, place, twist in motions.values()]
        ranges = next(iter(readings.values())).values
        self._memory.look(now, pose, ranges, places, self._radius)
        self._leave_out(written, self._memory.explained(pose, ranges, places, self._radius))
        ahead, behind, turned = self._rooms(now, pose)
        front = min(written["front"]) - SPARE

        def room() -> Reach:
            on, back = self._bends(now - self._span, pose)
            return [min(far, front) for far in on], back

        peers = self._encounters.groups(pose, motions, now, room)
        echoes = self._echoes(now, pose, backing=knowledge.robot.speed(now) <= BACKING)
        for name, *values in zip(GROUPS, peers, echoes, strict=True):
            written[name] = [*written[name], *values]
        rooms = dict(zip(ROOMS, (ahead, behind, turned), strict=True))
        return {
            **written,
            **rooms,
            "free_turn": list(free_turns(self._memory.around(pose, now - self._ground), self._half)),
            "bend_off": list(self._encounters.bends),
        }

    def _rooms(self, now: float, pose: Pose2) -> list[list[float]]:
        """How far it may drive on each bend, ahead and back, and turned to each heading [m]."""
        since, turned = now - self._ground, [0.0] * len(HEADINGS)
        if self._memory.may_turn(since, pose):
            turned = self._free(since, Pose2(pose.x, pose.y, 0.0), self._turned)
        return [*self._bends(since, pose), turned]

    def _bends(self, since: float, pose: Pose2) -> tuple[list[float], list[float]]:
        """How far it may drive on each bend, ahead and back, on ground that was known to be free since a time [m]."""
        found = self._free(since, pose, self._edges)
        return found[: len(BENDS)], [max(room - self._memory.cell, 0.0) for room in found[len(BENDS) :]]

    def _free(self, since: float, pose: Pose2, ways: Array) -> list[float]:
        """(n,) How far it may drive on each of some ways [m], on ground that was known to be free since a time [s]."""
        return [ROOM[strides] for strides in self._memory.strides(since, pose, ways)]

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

    def _echoes(self, now: float, pose: Pose2, *, backing: bool) -> tuple[float, float, float, float]:
        """What the memory adds to each of `GROUPS`; nothing ahead, where the beams look."""
        points = self._memory.around(pose, now - self._span)
        if not len(points):
            return (math.inf,) * 4
        left, right, rear = least_gaps(points, np.arctan2(points[:, 1], points[:, 0]), self._half, _SECTORS)
        # What lies beside the way is passed, and no reason to flinch; a turn would lead there.
        return math.inf, max(left, PASSED), max(right, PASSED), rear if backing else max(rear, PASSED)
