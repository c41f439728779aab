"""Encounters with other robots: how near they will come, and the escape on which the robot keeps clear of them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import NamedTuple

from rocs_bt import Pose2, Twist2
from rocs_bt.base.geometry import arc, arc_positions
from rocs_bt.control.arcs import BENDS
from rocs_bt.knowledge import Knowledge

from .gaps import hull_gaps

STEP = 0.1
"""Time step of the prediction of a peer's motion [s]."""

NEAR = 0.2
"""Gap to a peer below which the robot must drive away or stop [m]."""

PASSED = 0.27
"""Smallest reported gap beside or behind the robot [m]; so large that it neither fires Flinch nor keeps it active."""

TOUCH = 0.05
"""Smallest allowed gap to peers along an escape [m]."""

AWAY = 0.4
"""Speed of an escape [m/s]; that of Flinch in rules/avoid_collision.toml."""

SLOW = 0.15
"""Time lost while the robot accelerates to the speed of an escape [s]."""

FAR = (0.1, 0.4, 0.8, 1.2, 1.6, 2.0)
"""Times at which an escape is evaluated [s]."""

SURE = 0.14
"""Margin added to the safety distance, because the leader's pose is only estimated [m]."""

DUTY = 120.0
"""Time for which the robot keeps the safety distance to its leader after it has last followed it [s].

A reflex ends the following and may hold the robot for a minute, while others block the path. The robot must keep the
safety distance during this time too.
"""

PINNED = 5.0
"""Time with a peer nearer than `TOUCH`, after which escapes may have gaps as small as those of waiting [s].

Most peers drive on earlier.
"""

STAYS = 1.0
"""Time for which a chosen escape is kept, if it comes no nearer to a peer than waiting [s]."""

SCRAPES = -0.04
"""Gap between hull and a peer's circle below which the peer may touch the hull [m]; negative if they overlap."""

LEFT = 1.0
"""Time after which an escape from a peer that touches the hull must have gained distance [s]."""

LEAST = 0.1
"""Minimum free distance for an escape [m]."""

BENT = 0.02
"""Gap by which a bent escape must be better than the straight one, for each rad/m of its curvature [m]."""

Motion = tuple[float, Pose2, Twist2]
"""Motion of a peer: age of the estimate [s], estimated pose (world frame) and twist (body frame)."""

Reach = tuple[Sequence[float], Sequence[float]]
"""Free distance ahead and back on each of `rocs_bt.control.arcs.BENDS` [m]."""

Escape = tuple[int, float]
"""Escape: direction (1 ahead, -1 back, 0 none) and curvature [rad/m], left positive when driving ahead."""

Groups = tuple[float, float, float, float]
"""Reported gaps to peers in the groups front, left_gap, right_gap and rear [m]."""

NOBODY: Groups = (math.inf,) * 4


class Gap(NamedTuple):
    """Smallest predicted gap to a peer."""

    least: float  # [m] from hull to hull
    bearing: float  # [rad] of the peer's centre at that moment, left positive


class Encounters:
    """Gaps to known peers, reported in the standard groups of ranges, so that rules on ranges keep clear of peers.

    Args:
        knowledge: Knowledge of the robot.
        half: Half the hull's length and width [m].
        radius: Radius of a circle around a peer's base that contains its hull [m].
        horizon: Shortest prediction horizon [s].

    Attributes:
        bends: Curvatures of the escape ahead and of the escape back [rad/m]; 0 without an escape in the direction.
    """

    def __init__(
        self,
        knowledge: Knowledge,
        half: tuple[float, float],
        *,
        radius: float,
        horizon: float,
    ) -> None:
        self._knowledge = knowledge
        self._half = half
        self._radius = radius
        self._horizon = horizon
        self._pinned = math.inf  # [s] time since when a peer is nearer than TOUCH
        self.bends = (0.0, 0.0)
        self._chosen: tuple[float, Escape] = (-math.inf, (0, 0.0))  # end of STAYS [s], chosen escape
        self._duty = (-math.inf, "", 0.0, 0.0)  # end of the duty [s], leader, follow distance [m], safety distance [m]

    def groups(self, pose: Pose2, motions: Mapping[str, Motion], now: float, room: Callable[[], Reach]) -> Groups:
        """Gaps to report for the peers in each group [m]; also chooses an escape and sets `bends`.

        Args:
            pose: Pose of the robot, world frame.
            motions: Motion of each peer, by name.
            now: Present time [s].
            room: Returns the free distances on recently seen ground; called only if an escape is needed.
        """
        self.bends = (0.0, 0.0)
        if not motions:
            return NOBODY
        times, path = self._braking_path(pose, now)
        gaps = [self._gap(times, path, motion) for motion in motions.values()]
        left = min((g.least for g in gaps if 0.0 <= g.bearing <= 0.5 * math.pi), default=math.inf)
        right = min((g.least for g in gaps if -0.5 * math.pi <= g.bearing < 0.0), default=math.inf)
        rear = min((g.least for g in gaps if abs(g.bearing) > 0.5 * math.pi), default=math.inf)
        left, right, rear = max(left, PASSED), max(right, PASSED), max(rear, PASSED)
        if self._must_stop(times, path, motions):
            return TOUCH, left, right, TOUCH
        least = min(g.least for g in gaps)
        if least >= NEAR:
            return math.inf, left, right, rear
        escape, bend = self._escape(pose, motions, room())
        self.bends = (bend, 0.0) if escape > 0 else (0.0, bend)
        return (math.inf if escape > 0 else least), left, right, (rear if escape < 0 else least)

    def _must_stop(self, times: Sequence[float], path: Sequence[Pose2], motions: Mapping[str, Motion]) -> bool:
        """Whether the robot is too near to its leader, or will be before it has stopped if it brakes now."""
        stops = next(k for k, mine in enumerate(path, 1) if mine == path[-1])  # a leader may approach a stopped robot
        for name, _, safety in self._followed():
            if safety and name in motions:
                since, place, twist = motions[name]
                at, *_ = there = arc_positions(place, twist, [since + t for t in times[:stops]])
                near = min(math.dist(mine[:2], at) for mine in path)
                coming = min(math.dist(mine[:2], then) for mine, then in zip(path[:stops], there, strict=True))
                return min(near, coming) < safety + SURE
        return False

    def _followed(self) -> Iterator[tuple[str, float, float]]:
        """Leader, follow distance [m] and safety distance [m]; yields nothing if the robot has no leader."""
        agent, graph, now = self._knowledge.agent, self._knowledge.graph, self._knowledge.clock.now()
        for name in graph.related(agent, "follows"):
            edge = graph.edge(agent, "follows", name) or {}
            self._duty = now + DUTY, name, edge.get("distance", 0.0), edge.get("safety", 0.0)
        if self._duty[0] > now:
            yield self._duty[1:]

    def _escape(self, pose: Pose2, motions: Mapping[str, Motion], room: Reach) -> Escape:
        """Choose the escape that ends with the largest gap to all peers; direction 0 if waiting is better."""
        paths = {
            name: arc_positions(place, twist, [since + t for t in FAR])
            for name, (since, place, twist) in motions.items()
        }
        kept = [(Pose2(*paths[name][-1]), distance) for name, distance, _ in self._followed() if name in paths]

        def course(sign: float, bend: float, room: float) -> list[float]:
            mine = arc(pose, Twist2(sign, sign * bend), [min(AWAY * max(t - SLOW, 0.0), room) for t in FAR])
            if any(pose.distance(goal) > mine[-1].distance(goal) < least for goal, least in kept):
                return [-1.0] * len(FAR)  # this would lead away from one peer, but too near to the leader
            return [min(self._apart(here, *path[k]) for path in paths.values()) for k, here in enumerate(mine)]

        wait = course(1.0, 0.0, 0.0)
        least = self._least(wait)
        rooms = {
            (sign, bend): far
            for sign, side in zip((1, -1), room, strict=True)
            for bend, far in zip(BENDS, side, strict=True)
        }
        courses = {(sign, bend): course(sign, bend, far) for (sign, bend), far in rooms.items() if far > LEAST}
        now, (until, begun) = self._knowledge.clock.now(), self._chosen
        still = [min(low, gap - 0.01) for low, gap in zip(least, wait, strict=True)]
        if now < until and begun in courses and _leads_off(courses[begun], wait, still):
            return begun
        good = {off: gaps[-1] - BENT * abs(off[1]) for off, gaps in courses.items() if _leads_off(gaps, wait, least)}
        best = max(good, key=lambda off: good[off], default=(0, 0.0))
        self._chosen = now + STAYS, best
        return best

    def _least(self, wait: Sequence[float]) -> list[float]:
        """Smallest allowed gap of an escape at each time of `FAR` [m], given the gaps `wait` of a robot that waits."""
        now = self._knowledge.clock.now()
        self._pinned = min(self._pinned, now) if wait[0] < TOUCH else math.inf
        if now - self._pinned > PINNED:
            # The robot must soon leave a peer that may touch it: driving along the peer would touch it again.
            late = 0.02 if wait[0] < SCRAPES else -0.01
            return [gap + (late if t > LEFT else -0.01) for gap, t in zip(wait, FAR, strict=True)]
        # As long as nothing touches the hull, an escape needs no larger gap than waiting has.
        return [min(TOUCH, max(gap - 0.01, 0.0)) for gap in wait]

    def _braking_path(self, pose: Pose2, now: float) -> tuple[list[float], list[Pose2]]:
        """Predict the motion of the robot if it brakes as soon as it can: times from now on [s], and poses."""
        robot = self._knowledge.robot
        twist = Twist2(robot.speed(now), robot.turn_rate(now))
        if math.isnan(twist.forward + twist.turn):
            twist = Twist2(0.0)
        rim = max(map(abs, robot.locomotion.command(twist).tolist()))
        latency, braking = robot.locomotion.response.latency, rim / robot.locomotion.deceleration
        horizon = max(self._horizon, latency + braking)
        times = [i * STEP for i in range(math.ceil(horizon / STEP - 1e-9) + 1)]
        driven = []
        for t in times:
            slow = min(max(t - latency, 0.0), braking)
            braked = slow - 0.5 * slow * slow / braking if braking > 0.0 else 0.0
            driven.append(min(t, latency) + braked)
        return times, arc(pose, twist, driven)

    def _gap(self, times: Sequence[float], path: Sequence[Pose2], motion: Motion) -> Gap:
        """Smallest gap to a peer while the robot has the poses `path` at the times `times` [s]."""
        since, place, twist = motion
        places = arc_positions(place, twist, [since + t for t in times])
        gaps = hull_gaps(path, places, self._half, self._radius)
        least = min(gaps)
        k = gaps.index(least)
        return Gap(max(0.0, least), path[k].bearing(Pose2(*places[k])))

    def _apart(self, pose: Pose2, x: float, y: float) -> float:
        """Gap between the hull and a peer's circle at a position [m]; negative if the circle overlaps the edge."""
        return hull_gaps((pose,), ((x, y),), self._half, self._radius)[0]


def _leads_off(gaps: Sequence[float], wait: Sequence[float], least: Sequence[float]) -> bool:
    """Whether an escape ends with a clearly larger gap than waiting, and always keeps the smallest allowed gap.

    Args:
        gaps: Gap of the escape at each time of `FAR` [m].
        wait: Gap of a robot that waits, at the same times [m].
        least: Smallest allowed gap at the same times [m].
    """
    return gaps[-1] > wait[-1] + TOUCH and all(gap >= low for gap, low in zip(gaps, least, strict=True))
