"""Doors that the ring of range finders looks through: open or closed, with the observation as provenance."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

from rocs_bt import Analyze, Change, Metres, Pose2
from rocs_bt.base.units import PositiveMetres, PositiveRadians
from rocs_bt.interfaces.channel import Signals, Stamped

STATE = ("pose", "height", "tilt")
"""Signals of the state of the robot."""

STEP = 0.2
"""Evidence of one reading of one beam, in log odds [1]: successive readings are not independent."""

SURE = 3.0
"""Log odds from which a door counts as open or closed [1]: a probability of 95 %."""

MOST = 5.0
"""Maximum of the log odds [1], so that a door that moves is noticed."""

NOTICEABLE = math.log(2.0)
"""Change of the log odds [1] after which an observation is written again: the odds have doubled or halved."""

MARGIN = 0.05
"""Distance from the edges of a doorway within which beams are not evaluated [m]: errors of the pose."""

CELL = 0.1
"""Length of the parts of a doorway that are known to be free or not [m]."""


class ObserveDoors(Analyze):
    """Sets `open` of doors in view: true if beams pass through, false if echoes come from the door itself.

    Pose, `width` and `height` of a door must be known; its pose points through the doorway. Only beams count that have
    their cone between the posts, and at the present tilt above the floor and below the top of the doorway. A door is
    open only if beams have also passed through `min_width` of it side by side. Each result has an `observation` of the
    door with pose of the robot, time and confidence, made by this robot. It is written again when its confidence has
    changed noticeably.

    Attributes:
        ranges: Signal with the ranges of the ring, anticlockwise from straight ahead, with equal angles between beams.
        radius: Distance of the range finders from the centre of the robot [m].
        height: Height of the range finders above the origin of the robot [m].
        half_angle: Half the opening angle of each beam [rad].
        max_range: Maximum range [m].
        depth: Distance behind the door up to which an echo counts as the door [m].
        min_width: Minimum width of a passage [m].
    """

    ranges: str
    radius: PositiveMetres
    height: Metres
    half_angle: PositiveRadians
    max_range: PositiveMetres
    depth: PositiveMetres = 0.3
    min_width: PositiveMetres = 0.6

    def __post_init__(self) -> None:
        self._state: dict[str, Sequence[float]] = {}
        self._odds: dict[str, float] = {}
        self._free: dict[str, np.ndarray] = {}
        self._found: dict[str, tuple[bool, float]] = {}  # state and absolute log odds that were written

    def expects(self) -> Sequence[str]:
        """The ranges, and the signals of the state of the robot."""
        return (self.ranges, *STATE)

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        """Evaluate each reading of the ring at the newest state."""
        for sample in samples:
            self._state.update((name, sample.value[name]) for name in STATE if name in sample.value)
        known = len(self._state) == len(STATE) and all(math.isfinite(v) for each in self._state.values() for v in each)
        doors = self.knowledge.graph.nodes("door") if known else ()
        for sample in samples if doors else ():
            if self.ranges in sample.value:
                for door in doors:
                    yield from self._look(sample.t, door, np.array(sample.value[self.ranges]))

    def _look(self, t: float, door: str, ranges: np.ndarray) -> Iterable[Change]:
        """Evaluate one reading of the ring for one door."""
        graph, pose = self.knowledge.graph, self.knowledge.world.pose_of(door)
        width, height = graph.get(door, "width"), graph.get(door, "height")
        if pose is None or not width or not height:
            return
        near, far, aside = self._crossings(pose, len(ranges))
        inside = (near > 0.0) & (far + self.depth < self.max_range)
        inside &= np.abs(aside).max(axis=1) < 0.5 * width - MARGIN
        z, rise = self._state["height"][0] + self.height, math.tan(self._state["tilt"][0] + self.half_angle)
        inside &= (z - rise * (far + self.depth) > MARGIN) & (z + rise * (far + self.depth) < height - MARGIN)
        passed = inside & (ranges > far + self.depth)
        stopped = inside & (ranges > near - MARGIN) & (ranges <= far + self.depth)
        if not (passed | stopped).any():
            return
        odds = self._odds.get(door, 0.0) + STEP * (int(passed.sum()) - int(stopped.sum()))
        self._odds[door] = odds = min(max(odds, -MOST), MOST)
        free = self._free.setdefault(door, np.zeros(math.ceil(width / CELL), dtype=bool))
        for beams, value in ((passed, True), (stopped, False)):
            for beam in np.flatnonzero(beams):
                low, high = ((aside[beam, [0, -1]] + 0.5 * width) / CELL).tolist()
                free[math.ceil(min(low, high)) : math.floor(max(low, high))] = value
        is_open = odds >= SURE and CELL * _longest(free) >= self.min_width
        state, written = self._found.get(door, (None, 0.0))
        known = state == graph.get(door, "open") == is_open and abs(abs(odds) - written) < NOTICEABLE
        if (is_open or odds <= -SURE) and not known:
            self._found[door] = is_open, abs(odds)
            yield self._write(t, door, is_open, 1.0 / (1.0 + math.exp(-abs(odds))))

    def _crossings(self, door: Pose2, beams: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Where the cones of the beams cross the line of a door.

        Returns:
            near: Shortest distance from the range finder to the line, shape (beams,) [m]; 0 or less if a ray misses it.
            far: Longest such distance, shape (beams,) [m].
            aside: Positions of the crossings of right edge, axis and left edge along the line, from the middle of the
                door, shape (beams, 3) [m].
        """
        robot = Pose2(*self._state["pose"])
        bearings = robot.yaw + 2.0 * math.pi / beams * np.arange(beams)
        c, s = math.cos(door.yaw), math.sin(door.yaw)
        x = robot.x - door.x + self.radius * np.cos(bearings)
        y = robot.y - door.y + self.radius * np.sin(bearings)
        through, along = (c * x + s * y)[:, None], (c * y - s * x)[:, None]
        angles = bearings[:, None] - door.yaw + self.half_angle * np.array([-1.0, 0.0, 1.0])
        cos = np.cos(angles)
        distances = -through / np.where(np.abs(cos) > 1e-6, cos, 1e-6)
        return distances.min(axis=1), distances.max(axis=1), along + distances * np.sin(angles)

    def _write(self, t: float, door: str, is_open: bool, confidence: float) -> Change:
        """Write the state of a door with the observation that it comes from."""
        graph, robot = self.knowledge.graph, self.knowledge.agent
        node = f"{door} seen by {robot}"
        values = {"pose": Pose2(*self._state["pose"]), "time": t, "confidence": confidence}
        with graph.locked():
            if graph.has(node):
                graph.set(node, **values)
            else:
                graph.add(node, "observation", **values)
                graph.relate(node, "observes", door)
                graph.relate(node, "made_by", robot)
            graph.set(door, open=is_open)
        return self.change(t, "door", door, open=is_open, confidence=confidence)


def _longest(free: np.ndarray) -> int:
    """Length of the longest run of true values."""
    best = run = 0
    for value in free.tolist():
        run = run + 1 if value else 0
        best = max(best, run)
    return best
