"""Encounters: how near other robots come, and where a robot goes from them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from ..control.arcs import BENDS
from ..geometry import Pose2, Twist2, arc, arc_positions, hull_gaps
from ..knowledge import Knowledge

STEP = 0.1
"""Time between two looks ahead at a peer [s]."""

NEAR = 0.2
"""Gap to a peer below which the robot must go from it, or stand [m]."""

PASSED = 0.27
"""A gap beside or behind that is no reason to begin flinching, nor to go on with it [m]."""

TOUCH = 0.05
"""Gap that a way off must keep, or it is none [m]."""

AWAY = 0.4
"""Speed at which it would go, which is Flinch's in rules/avoid_collision.toml [m/s]."""

SLOW = 0.15
"""Time lost until it is that fast [s]."""

FAR = (0.1, 0.4, 0.8, 1.2, 1.6, 2.0)
"""When it looks how that came out [s]."""

SURE = 0.14
"""By so much it keeps more than the safety distance, since it only estimates where its leader is [m]."""

DUTY = 120.0
"""For so long it keeps its distance after it was told to follow [s].

A reflex interrupts the one, not the other, and may stand for a minute where others jam the way.
"""

PINNED = 5.0
"""Who was all but touched for so long goes wherever it comes no nearer than if it stood [s]; most go on before."""

STAYS = 1.0
"""For so long it keeps to the way off that it chose, while it comes no nearer there than if it stood [s]."""

SCRAPES = -0.04
"""Gap to a peer's circle at which that peer may touch the hull, whichever way it looks [m]."""

LEFT = 1.0
"""By then a way off must have left who touches the hull [s]."""

LEAST = 0.1
"""Room that is worth going for [m]."""

BENT = 0.02
"""So much more than straight on a way off must gain for each rad/m that it bends [m]."""

Motion = tuple[float, Pose2, Twist2]
"""How a peer moves: since how long [s], from where, and how fast."""

Reach = tuple[Sequence[float], Sequence[float]]
"""How far a robot may drive ahead, and back, on each of `control.arcs.BENDS` [m]."""

WayOff = tuple[int, float]
"""A way to go: 1 ahead, -1 back or 0 nowhere, and its bend, left positive when the robot drives ahead [rad/m]."""

Groups = tuple[float, float, float, float]
"""What peers add to front, left_gap, right_gap and rear [m]."""

NOBODY: Groups = (math.inf,) * 4


class Gap(NamedTuple):
    """How near a peer comes in the next moments."""

    least: float  # [m] from hull to hull, where that is least
    bearing: float  # [rad] of the peer's centre at that moment, left positive


class Encounters:
    """Tells the standard groups of the peers that a robot knows, so that rules which know ranges alone keep clear.

    Args:
        knowledge: The robot's.
        half: Half its hull's length and width [m].
        radius: Of a circle around a peer's base that holds its hull [m].
        reaction: From a reading to wheels that begin to brake [s].
        deceleration: Of braking wheels [m/s2].
        horizon: How far to look ahead at least [s].

    Attributes:
        bends: On which the ways off ahead and back go, 0 for none [rad/m].
    """

    def __init__(
        self,
        knowledge: Knowledge,
        half: tuple[float, float],
        *,
        radius: float,
        reaction: float,
        deceleration: float,
        horizon: float,
    ) -> None:
        self._knowledge = knowledge
        self._half = half
        self._radius = radius
        self._reaction = reaction
        self._deceleration = deceleration
        self._horizon = horizon
        self._pinned = math.inf  # since when somebody touches it, or all but [s]
        self.bends = (0.0, 0.0)
        self._off: tuple[float, WayOff] = (-math.inf, (0, 0.0))  # until when it keeps to which way off [s]
        self._duty = (-math.inf, "", 0.0, 0.0)  # until when [s], to keep what distance from whom

    def groups(self, pose: Pose2, motions: Mapping[str, Motion], now: float, room: Callable[[], Reach]) -> Groups:
        """What the peers add to each group; where needed it asks how much room was seen lately."""
        self.bends = (0.0, 0.0)
        if not motions:
            return NOBODY
        times, way = self._way(pose, now)
        gaps = [self._gap(times, way, motion) for motion in motions.values()]
        left = min((g.least for g in gaps if 0.0 <= g.bearing <= 0.5 * math.pi), default=math.inf)
        right = min((g.least for g in gaps if -0.5 * math.pi <= g.bearing < 0.0), default=math.inf)
        rear = min((g.least for g in gaps if abs(g.bearing) > 0.5 * math.pi), default=math.inf)
        left, right, rear = max(left, PASSED), max(right, PASSED), max(rear, PASSED)
        if self._must_stand(times, way, motions):
            return TOUCH, left, right, TOUCH
        least = min(g.least for g in gaps)
        if least >= NEAR:
            return math.inf, left, right, rear
        escape, bend = self._escape(pose, motions, room())
        self.bends = (bend, 0.0) if escape > 0 else (0.0, bend)
        return (math.inf if escape > 0 else least), left, right, (rear if escape < 0 else least)

    def _must_stand(self, times: Sequence[float], way: Sequence[Pose2], motions: Mapping[str, Motion]) -> bool:
        """Whether the robot would come too near to whom it follows before it stands, or is so already."""
        stops = next(k for k, mine in enumerate(way, 1) if mine == way[-1])  # once it stands its leader may come
        for name, _, safety in self._followed():
            if safety and name in motions:
                since, place, twist = motions[name]
                at, *_ = there = arc_positions(place, twist, [since + t for t in times[:stops]])
                near = min(math.dist(mine[:2], at) for mine in way)
                coming = min(math.dist(mine[:2], then) for mine, then in zip(way[:stops], there, strict=True))
                return min(near, coming) < safety + SURE
        return False

    def _followed(self) -> Iterator[tuple[str, float, float]]:
        """Whom the robot follows, at which distance, and nearer than what it must not drive [m]."""
        agent, graph, now = self._knowledge.agent, self._knowledge.graph, self._knowledge.clock.now()
        for name in graph.related(agent, "follows"):
            edge = graph.edge(agent, "follows", name) or {}
            self._duty = now + DUTY, name, edge.get("distance", 0.0), edge.get("safety", 0.0)
        if self._duty[0] > now:
            yield self._duty[1:]

    def _escape(self, pose: Pose2, motions: Mapping[str, Motion], room: Reach) -> WayOff:
        """Where to go from peers that come near."""
        ways = {
            name: arc_positions(place, twist, [since + t for t in FAR])
            for name, (since, place, twist) in motions.items()
        }
        kept = [(Pose2(*ways[name][-1]), distance) for name, distance, _ in self._followed() if name in ways]

        def course(sign: float, bend: float, room: float) -> list[float]:
            mine = arc(pose, Twist2(sign, sign * bend), [min(AWAY * max(t - SLOW, 0.0), room) for t in FAR])
            if any(pose.distance(goal) > mine[-1].distance(goal) < least for goal, least in kept):
                return [-1.0] * len(FAR)  # out of one's way into that of whom it follows
            return [min(self._apart(here, *way[k]) for way in ways.values()) for k, here in enumerate(mine)]

        stand = course(1.0, 0.0, 0.0)
        least = self._least(stand)
        rooms = {
            (sign, bend): far
            for sign, side in zip((1, -1), room, strict=True)
            for bend, far in zip(BENDS, side, strict=True)
        }
        courses = {(sign, bend): course(sign, bend, far) for (sign, bend), far in rooms.items() if far > LEAST}
        now, (until, begun) = self._knowledge.clock.now(), self._off
        still = [min(low, gap - 0.01) for low, gap in zip(least, stand, strict=True)]
        if now < until and begun in courses and _leads_off(courses[begun], stand, still):
            return begun
        good = {off: gaps[-1] - BENT * abs(off[1]) for off, gaps in courses.items() if _leads_off(gaps, stand, least)}
        best = max(good, key=lambda off: good[off], default=(0, 0.0))
        self._off = now + STAYS, best
        return best

    def _least(self, stand: Sequence[float]) -> list[float]:
        """The gaps that a way off must keep at each look, given those that standing would keep [m]."""
        now = self._knowledge.clock.now()
        self._pinned = min(self._pinned, now) if stand[0] < TOUCH else math.inf
        if now - self._pinned > PINNED:
            # Who may touch it must be left soon: to drive along somebody is to touch them again.
            late = 0.02 if stand[0] < SCRAPES else -0.01
            return [gap + (late if t > LEFT else -0.01) for gap, t in zip(stand, FAR, strict=True)]
        # It need keep no more than if it stood, as long as nobody touches it.
        return [min(TOUCH, max(gap - 0.01, 0.0)) for gap in stand]

    def _way(self, pose: Pose2, now: float) -> tuple[list[float], list[Pose2]]:
        """Where the robot is at some times from now on [s], if it brakes as soon as it can."""
        robot = self._knowledge.robot
        twist = Twist2(robot.speed(now), robot.turn_rate(now))
        if math.isnan(twist.forward + twist.turn):
            twist = Twist2(0.0)
        rim = max(map(abs, robot.drive.wheel_speeds(twist).tolist()))
        braking = rim / self._deceleration
        horizon = max(self._horizon, self._reaction + braking)
        times = [i * STEP for i in range(math.ceil(horizon / STEP - 1e-9) + 1)]
        driven = []
        for t in times:
            slow = min(max(t - self._reaction, 0.0), braking)
            braked = slow - 0.5 * slow * slow / braking if braking > 0.0 else 0.0
            driven.append(min(t, self._reaction) + braked)
        return times, arc(pose, twist, driven)

    def _gap(self, times: Sequence[float], way: Sequence[Pose2], motion: Motion) -> Gap:
        """How near a peer comes in the next moments."""
        since, place, twist = motion
        places = arc_positions(place, twist, [since + t for t in times])
        gaps = hull_gaps(way, places, self._half, self._radius)
        least = min(gaps)
        k = gaps.index(least)
        return Gap(max(0.0, least), way[k].bearing(Pose2(*places[k])))

    def _apart(self, pose: Pose2, x: float, y: float) -> float:
        """Between the hull, a rectangle, and a peer's circle at a point [m]; negative: it is over the hull's edge."""
        return hull_gaps((pose,), ((x, y),), self._half, self._radius)[0]


def _leads_off(gaps: Sequence[float], stand: Sequence[float], least: Sequence[float]) -> bool:
    """Whether a way's gaps end well above those of who stands, and keep above the least all along [m]."""
    return gaps[-1] > stand[-1] + TOUCH and all(gap >= low for gap, low in zip(gaps, least, strict=True))
