"""Monitor of a robot with three beams: standard groups of ranges from beams, short memory and known peers."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from rocs_bt import Fault, InputError, Metres, Pose2, Radians, Reading, Signal
from rocs_bt.base.geometry import along_arc
from rocs_bt.base.units import ANGLE, LENGTH, PositiveMetres, PositiveRadians, PositiveSeconds
from rocs_bt.control.arcs import BENDS, HEADINGS
from rocs_bt.interfaces.channel import Signals
from rocs_bt.monitor import RangeMonitor

from .edges import leading_edges, turned_edges
from .encounter import PASSED, Encounters, Reach
from .gaps import free_turns, least_gaps
from .local_memory import Array, LocalMemory, Mount

GROUPS = ("front", "left_gap", "right_gap", "rear")
"""Standard groups; after the values of its beams, each group has a value for peers and one for remembered echoes."""

ROOMS = {
    "room_ahead": (len(BENDS), f"ahead, on bends of {', '.join(f'{bend:g}' for bend in BENDS)} rad/m"),
    "room_behind": (len(BENDS), "back, on the same bends"),
    "room_turned": (
        len(HEADINGS),
        f"after a turn on the spot to each of {len(HEADINGS)} headings of the world frame, from west by south",
    ),
}
"""Signals of free distances: number of values, and description."""

SECTORS = ((math.radians(20.0), 1.0), (math.radians(40.0), 0.85), (math.radians(60.0), 0.6))
"""Largest angle off the rear axis [rad] and weight of each sector behind the robot, as for a ring of sonars."""

_SECTORS = np.array(SECTORS)

SPARE = 0.3
"""Gap that an escape ahead leaves to echoes [m]."""

STRIDES = np.linspace(0.1, 1.0, 10)
"""Distances after which the ground under the hull's leading edge is examined [m]."""

ROOM = (0.0, *STRIDES.tolist())
"""Free distance for each number of free strides [m]."""

BACKING = -0.02
"""Forward speed above which the robot does not count as driving back [m/s]."""


class SurroundMonitor(RangeMonitor):
    """RangeMonitor with standard groups that also contain the gaps to the nearest peer and the nearest recent echo.

    Rules on ranges therefore protect a robot with only three beams. The monitor needs the length and width of the body,
    and a monitor before it that writes `peer_range`.

    *Peers* are those of the world model, where the robot's Analyze stores their poses and speeds, also while they are
    occluded. The value of a peer is the smallest gap between the hulls while this robot brakes and the peer drives on.
    A peer that approaches, or that a corner of the turning hull would hit, therefore counts as nearer. A near peer is
    reported in the group from which a reflex must drive away: in `rear` if driving ahead increases the gap, in `front`
    if driving back increases it, and in both groups if the robot should stop.

    *Echoes* are remembered for `max_echo_age`; the gap to an echo is divided by the weight of its sector. Echoes behind
    the robot count only while it drives back, since stationary things come no nearer otherwise.

    *Ground* is remembered for `max_free_ground_age` where it was seen to be free. `room_ahead` and `room_behind` are
    the free distances on each of `rocs_bt.control.arcs.BENDS` [m]. The distance back is one square of the map shorter,
    because a square that the hull covered only in part counts as free although no beam saw the rest. `room_turned` is
    the free distance after a turn on the spot to each of `rocs_bt.control.arcs.HEADINGS` [m]; it is 0 if a corner of
    the hull would sweep unknown ground during the turn. An escape from a peer uses only ground that was seen within the
    last `max_echo_age`.

    `free_turn` is the angle by which the robot can turn on the spot to the left and to the right [rad] before a corner
    of the hull comes near to an echo. It uses echoes for the longer time `max_free_ground_age`, since walls do not
    move.

    All groups are invalid while the pose or `peer_range` is invalid: a blind robot must not drive as if it were alone.

    Attributes:
        mounts: x [m], y [m] and yaw [rad] of each beam in the body frame.
        half_angle: Half the opening angle of a beam's cone [rad].
        max_range: Maximum range of the beams [m].
        max_echo_age: Time for which an echo counts [s].
        max_free_ground_age: Time for which ground counts as free after it was seen to be free [s].
        peer_radius: Radius of a circle around a peer's base that contains its hull [m].
        horizon: Shortest prediction horizon [s].
    """

    mounts: tuple[tuple[Metres, Metres, Radians], ...]
    half_angle: PositiveRadians
    max_range: PositiveMetres
    max_echo_age: PositiveSeconds
    max_free_ground_age: PositiveSeconds
    peer_radius: PositiveMetres
    horizon: PositiveSeconds = 0.7

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.max_free_ground_age < self.max_echo_age:
            found = f"found {self.max_free_ground_age:g} s and {self.max_echo_age:g} s"
            raise InputError(
                Fault(f"max_free_ground_age of monitor '{self.name}' must be at least max_echo_age, {found}.")
            )
        if missed := [name for name in GROUPS if name not in self.groups]:
            raise InputError(
                Fault(f"monitor '{self.name}' needs the groups {', '.join(GROUPS)}; {missed} are missing.")
            )
        if len(self.mounts) != self.beams:
            raise InputError(Fault(f"mounts of monitor '{self.name}' must be x, y and yaw of {self.beams} beams."))
        body = self.knowledge.graph.attributes(self.knowledge.agent)
        if not (body.get("length") and body.get("width")):
            raise InputError(Fault(f"monitor '{self.name}' needs the robot's length and width in its [body] table."))
        self._half = 0.5 * body["length"], 0.5 * body["width"]
        self._memory = LocalMemory(
            [Mount(*mount) for mount in self.mounts],
            self.half_angle,
            self.max_range,
            self.max_free_ground_age,
            self._half,
        )
        self._edges = leading_edges(self._half, STRIDES).reshape(2 * len(BENDS), len(STRIDES), -1, 2)
        self._turned = turned_edges(self._half, STRIDES)
        self._encounters = Encounters(self.knowledge, self._half, radius=self.peer_radius, horizon=self.horizon)

    def signals(self) -> Sequence[Signal]:
        raw, *groups = super().signals()
        rooms = [
            Signal(
                name,
                size,
                (LENGTH,) * size,
                (0.0, float(STRIDES[-1])),
                self.max_age,
                f"Free distance {words}, on ground that is known to be free.",
            )
            for name, (size, words) in ROOMS.items()
        ]
        doc = "Bend of the escape from a near peer, ahead and back."
        off = Signal("bend_off", 2, (ANGLE / LENGTH,) * 2, (min(BENDS), max(BENDS)), self.max_age, doc)
        doc = "Free turn on the spot to the left and to the right, before a corner comes near to an echo."
        turn = Signal("free_turn", 2, (ANGLE,) * 2, (0.0, math.pi), self.max_age, doc)
        wider = (self._wider(signal) if signal.name in GROUPS else signal for signal in groups)
        return [raw, *wider, *rooms, turn, off]  # in the order of writing, which halves the time

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
        self._memory.look(now, pose, ranges, places, self.peer_radius)
        self._remove_peers(written, self._memory.explained(pose, ranges, places, self.peer_radius))
        ahead, behind, turned = self._rooms(now, pose)
        front = min(written["front"]) - SPARE

        def room() -> Reach:
            on, back = self._bends(now - self.max_echo_age, pose)
            return [min(far, front) for far in on], back

        peers = self._encounters.groups(pose, motions, now, room)
        echoes = self._echoes(now, pose, backing=knowledge.robot.speed(now) <= BACKING)
        for name, *values in zip(GROUPS, peers, echoes, strict=True):
            written[name] = [*written[name], *values]
        rooms = dict(zip(ROOMS, (ahead, behind, turned), strict=True))
        return {
            **written,
            **rooms,
            "free_turn": list(free_turns(self._memory.around(pose, now - self.max_free_ground_age), self._half)),
            "bend_off": list(self._encounters.bends),
        }

    def _rooms(self, now: float, pose: Pose2) -> list[list[float]]:
        """Values of `room_ahead`, `room_behind` and `room_turned` [m], on ground known to be free."""
        since, turned = now - self.max_free_ground_age, [0.0] * len(HEADINGS)
        if self._memory.may_turn(since, pose):
            turned = self._free(since, Pose2(pose.x, pose.y, 0.0), self._turned)
        return [*self._bends(since, pose), turned]

    def _bends(self, since: float, pose: Pose2) -> tuple[list[float], list[float]]:
        """Free distances along arcs of each curvature, ahead and back [m], on ground seen free since a time [s]."""
        found = self._free(since, pose, self._edges)
        return found[: len(BENDS)], [max(room - self._memory.cell, 0.0) for room in found[len(BENDS) :]]

    def _free(self, since: float, pose: Pose2, paths: Array) -> list[float]:
        """Free distance along each path [m], on ground seen free since a time [s]; shape (n,)."""
        return [ROOM[strides] for strides in self._memory.strides(since, pose, paths)]

    def _wider(self, signal: Signal) -> Signal:
        """Signal of a group, with additional values for the nearest peer and for the nearest remembered echo."""
        doc = f"{signal.doc} Then the nearest peer, and the nearest recent echo."
        size = signal.size + 2
        return replace(signal, size=size, dimensions=signal.dimensions[:1] * size, doc=doc)

    def _remove_peers(self, written: dict[str, Sequence[float]], explained: Sequence[bool]) -> None:
        """Remove echoes that known peers explain from the groups: the world model knows peers better than an echo."""
        if any(explained):
            for name, group in self.groups.items():
                beams = zip(group.beams, written[name], strict=False)
                written[name] = [math.inf if explained[beam] else value for beam, value in beams] or written[name]

    def _echoes(self, now: float, pose: Pose2, *, backing: bool) -> tuple[float, float, float, float]:
        """Gap to the remembered obstacles in each of `GROUPS` [m]; +inf for `front`, which the beams measure."""
        points = self._memory.around(pose, now - self.max_echo_age)
        if not len(points):
            return (math.inf,) * 4
        left, right, rear = least_gaps(points, np.arctan2(points[:, 1], points[:, 0]), self._half, _SECTORS)
        # Things beside the path do not make the robot back off, since only a turn would lead to them.
        return math.inf, max(left, PASSED), max(right, PASSED), rear if backing else max(rear, PASSED)
