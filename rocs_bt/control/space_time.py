"""SpaceTime: motion among movers, planned by a beam search in space and time.

A plan is a sequence of layers. In each of them the robot ramps to one of a few target speeds and turn rates. Staying,
turning on the spot and driving back are targets like all others, so that waiting and yielding need no rules of their
own. The search keeps the cheapest states of each layer that differ from each other (beam search; Lowerre, The HARPY
speech recognition system, 1976). The costs are times: of driving to the goal, of coming close, and of contacts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ..base.geometry import Pose2, Twist2
from .footprint import Footprint
from .locomotion import Array
from .prediction import Prediction
from .way_field import WayField

LAYERS, LAYER, PARTS = 8, 0.4, 2
"""Number of layers of a plan, duration of a layer [s], and poses in a layer at which gaps are checked.

In further layers the robot brakes: a plan ends in a stop.
"""

THERE = 0.5
"""Way that is left from which on a layer costs less than its duration [m]."""

FINE = 3
"""Number of first layers with all targets; further ahead fewer do."""

WIDTH = 48
"""Number of states that are kept after each layer."""

MARGIN = 0.06
"""Gap to a predicted disc that counts as contact [m]."""

MAX_MARGIN = 0.36
"""Greatest share of the uncertainty of a position in that gap [m]: what is far ahead must not close the way."""

PARTING = 1.2
"""Time after which the disc of a mover that touches the robot at the start has its full size [s]; it grows from half
of this time on, so that the robot can leave it.
"""

SOON = 0.9
"""Inverse of the time ahead at which a contact counts half [1/s], because a new plan comes before it."""

DRIVEN, BY_SPEED, STRUCK = 50.0, 25.0, 25.0
"""Cost of a contact into which the robot drives [s], of that per speed [s2/m], and of one in which it stays [s]."""

STAYING = 0.06
"""Speed below which a robot stays [m/s]."""

SLIP = 0.1
"""Distance of the centre about which a skid-steered robot turns from the middle of its hull [m]: while it turns, its
flanks move sideways.
"""

CLOSE = 3.0
"""Cost per second within the personal space at zero gap and a speed of about 0.9 m/s."""

WRONG_SIDE, PASSING = 0.4, 1.2
"""Share of that cost for a mover on the side on which the robot prefers to pass, and the gap from which it is 0 [m]."""

TIGHT, SOLID = 0.02, 40.0
"""Static gap below which driving costs extra [m], and that cost [s2/m]."""

SIDES = ("right", "left", "either")
"""Sides on which a robot may prefer to pass others."""

REVERSE, IN_REVERSE = 1.5, -0.05
"""Additional cost of a second in reverse, and speed below which it is one [m/s]."""

TURNS, SPEEDS, TURNED, AT_ONCE = 0.03, 0.04, 0.03, 0.02
"""Cost of a change of the turn rate [s2/rad] and of the speed [s2/m], of a turn [s/rad], and of the difference of the
first targets from the present motion, in both units: of two equal plans the robot takes the calmer one.
"""

MOVES, MOVING = 5.0, 0.05
"""Further cost of each pose at which the robot moves below that gap [s], and speed of its corners from which it does
[m/s].
"""

NARROW, WALL = 0.25, 0.6
"""Static gap below which speed costs [m], and that cost per gap that is lacking [s/m2]."""

EDGE, DEPTH, LEAST, MOST = 0.3, 0.3, 0.4, 1.3
"""Factor on the price of a contact at the edge of a predicted disc, where it may not happen, depth in the disc by which
the factor grows by 1 [m], and its bounds.
"""

RESTING = 0.25
"""Cost of closeness of a robot at rest, beside the square of its speed [m2/s2]."""

AHEAD, AWAY, NEAR_GOAL = 0.25, 0.6, 0.5
"""Distance ahead at which the way to the goal is compared with that from here [m], cost of a heading across the way,
twice that of one away from it [s], and way that is left from which on it costs less, down to 0 at this distance [m].
"""

PACE = 0.9
"""Share of the cruise speed at which the rest of the way is estimated."""

BACK_TURN = 0.55
"""Share of the turn rate in reverse."""

KEY = (0.25, 0.25, 0.4, 0.4)
"""Differences of x [m], y [m], yaw [rad] and speed [m/s] below which two states of a layer count as one."""


@dataclass(frozen=True, kw_only=True)
class Manners:
    """How a robot behaves among people.

    Attributes:
        personal_space: Gap below which closeness costs [m].
        side: Side on which it prefers to pass others, of `SIDES`.
    """

    personal_space: float = 0.35
    side: str = "right"


@dataclass(frozen=True, kw_only=True)
class MotionLimits:
    """Limits of planned motions.

    Attributes:
        cruise: Forward speed [m/s].
        back: Speed in reverse [m/s].
        turn_rate: Turn rate [rad/s].
        acceleration, deceleration: Rates of change of the speed [m/s2].
        turn_acceleration: Rate of change of the turn rate [rad/s2].
        top: Greatest sum of the speed and of `arm` times the turn rate, such as the speed of the outer wheels [m/s].
        arm: Distance of these wheels from the middle [m]; 0 if speed and turn rate are independent.
    """

    cruise: float
    back: float
    turn_rate: float
    acceleration: float
    deceleration: float
    turn_acceleration: float
    top: float = math.inf
    arm: float = 0.0


class TimedPlan(NamedTuple):
    """Planned motion.

    Attributes:
        times: Times of the poses, from the start on, shape (n,) [s].
        poses: x [m], y [m], yaw [rad], world frame, continuous yaw, shape (n, 3).
        contact: Probability of the most probable hypothesis with a contact that the plan accepts.
        cost: Cost of the plan, the rest of the way included [s].
    """

    times: Array
    poses: Array
    contact: float
    cost: float


class _States(NamedTuple):
    """n states at the end of a layer.

    `hit` are the probabilities of contacts with each mover so far, shape (n, movers), and `held` is the way that was
    left when the last contact began [m].
    """

    x: Array
    y: Array
    yaw: Array
    v: Array
    w: Array
    cost: Array
    hit: Array
    held: Array

    def of(self, chosen: npt.NDArray[np.intp]) -> _States:
        return _States(*(column[chosen] for column in self))


class _Company(NamedTuple):
    """Predicted movers as discs, in m rows of which each is a hypothesis, at the times of all poses of a plan, (k).

    Attributes:
        at: Centres, world frame, shape (m, k, 2) [m].
        outer: Distances from the hull at which contact begins, shape (m, k) [m].
        weight: Probabilities of the rows, shape (m,).
        mover: Index of the mover of each row, from 0 on, shape (m,).
    """

    at: Array
    outer: Array
    weight: Array
    mover: npt.NDArray[np.intp]

    @staticmethod
    def of(prediction: Prediction, hull: Footprint, start: Pose2) -> _Company:
        outer = prediction.radius[:, None] + MARGIN + np.minimum(prediction.margin, MAX_MARGIN)
        # What touches the robot already is no new contact: its disc is smaller at first, until the robot has left it.
        gaps = prediction.gaps(hull, np.array([start]), prediction.times[:1])[0] + prediction.radius
        left = np.clip(2.0 - 2.0 * (prediction.times - prediction.times[0]) / PARTING, 0.0, 1.0)
        outer += np.minimum((gaps - 0.01)[:, None] - outer, 0.0) * left * (gaps < outer[:, 0])[:, None]
        mover = np.unique(prediction.owner, return_inverse=True)[1]
        return _Company(prediction.positions, outer, prediction.weight, mover)


class SpaceTime:
    """Planner of motions among movers."""

    def __init__(self, hull: Footprint, limits: MotionLimits, manners: Manners) -> None:
        self._hull, self._limits, self._manners = hull, limits, manners
        near = _targets(limits, (0.0, -0.44, 0.44, -1.0, 1.0), (0.3, 0.65, 1.0), (0.4, 1.0))
        far = _targets(limits, (0.0, -1.0, 1.0), (0.5, 1.0), (1.0,))
        brakes = math.ceil(max(limits.cruise, limits.back) / (limits.deceleration * LAYER) - 1e-9)
        # The last layers only brake: a plan that ends in motion would be free of what comes just after its horizon.
        self._targets = [near if layer < FINE else far for layer in range(LAYERS)]
        self._targets += [(np.zeros(1), np.zeros(1))] * brakes
        self._h = LAYER / PARTS
        self._ramp = self._h * (np.arange(PARTS)[:, None] + 0.5)  # middles of the parts of a layer [s]

    def times(self, start: float) -> Array:
        """Times of the poses of a plan from a time on, at which it needs the prediction, shape (k,) [s]."""
        return np.asarray(start + self._h * np.arange(len(self._targets) * PARTS + 1), float)

    def plan(
        self,
        t: float,
        start: Pose2,
        twist: Twist2,
        way: WayField,
        prediction: Prediction,
        back: float = math.inf,
    ) -> TimedPlan:
        """Plan a motion.

        Args:
            t: Time of the start [s].
            start: Pose at the start, world frame.
            twist: Velocity at the start, body frame; its lateral part is ignored.
            way: Obstacles that do not move, and the way to the goal.
            prediction: Predicted movers at the times of `times(t)`.
            back: Greatest speed in reverse, such as the ground behind the robot allows [m/s].
        """
        one, company = np.ones(1), _Company.of(prediction, self._hull, start) if len(prediction) else None
        movers = int(company.mover.max()) + 1 if company is not None else 0
        x, y, yaw, v, w = (value * one for value in (*start, twist.forward, twist.turn))
        states = _States(x, y, yaw, v, w, cost=np.zeros(1), hit=np.zeros((1, movers)), held=np.zeros(1))
        here = states.x, states.y, np.cos(states.yaw), np.sin(states.yaw)
        gaps = partial(way.gaps, fine=bool(way.gaps(*here)[0] < TIGHT))
        tight = min(TIGHT, float(gaps(*here)[0]) - 0.005)  # a robot that is close already may leave
        poses: list[Array] = []
        parents: list[npt.NDArray[np.intp]] = []
        total = np.zeros(1)
        for layer, (v, w) in enumerate(self._targets):
            v, count, wide = np.maximum(v, -back), len(states.x), len(v)
            parent = np.repeat(np.arange(count), wide)
            before = states.of(parent)
            states, driven = self._ramped(before, np.tile(v, count), np.tile(w, count), layer, gaps, tight, company)
            states, rest = self._rest(states, before, way)
            total = states.cost + rest
            kept = self._different(states, total)
            poses.append(driven[:, :, kept])
            parents.append(parent[kept])
            states, total = states.of(kept), total[kept]
        best = first = int(total.argmin())
        rows: list[Array] = []
        for driven, parent in zip(reversed(poses), reversed(parents), strict=True):
            rows.append(driven[:, :, best].T)
            best = int(parent[best])
        path = np.concatenate([[tuple(start)], *reversed(rows)])
        return TimedPlan(self.times(t), path, float(states.hit[first].max(initial=0.0)), float(total[first]))

    def _ramped(
        self,
        s: _States,
        v: Array,
        w: Array,
        layer: int,
        gaps: Callable[..., Array],
        tight: float,
        company: _Company | None,
    ) -> tuple[_States, Array]:
        """States after a layer of ramps from states (n) to target speeds and turn rates, and poses (3, PARTS, n)."""
        limits, h = self._limits, self._h
        up = np.where(s.v >= 0.0, limits.acceleration, limits.deceleration)
        down = np.where(s.v > 0.0, limits.deceleration, limits.acceleration)
        faster, turned, swing = v - s.v, w - s.w, limits.turn_acceleration
        reached = s.v + np.minimum(np.maximum(faster, -down * LAYER), up * LAYER)
        turning = s.w + np.minimum(np.maximum(turned, -swing * LAYER), swing * LAYER)
        cost = s.cost + TURNS * np.abs(turning - s.w) + SPEEDS * np.abs(reached - s.v)
        cost += TURNED * LAYER * np.abs(turning) + REVERSE * LAYER * (reached < IN_REVERSE)
        if layer == 0:
            cost += AT_ONCE * (np.abs(turned) + np.abs(faster))
        ramp = self._ramp
        speed = s.v + np.minimum(np.maximum(faster, -down * ramp), up * ramp)
        turn = s.w + np.minimum(np.maximum(turned, -swing * ramp), swing * ramp)
        yaw = s.yaw + h * np.cumsum(turn, axis=0)
        middle = yaw - 0.5 * h * turn
        x = s.x + h * np.cumsum(speed * np.cos(middle), axis=0)
        y = s.y + h * np.cumsum(speed * np.sin(middle), axis=0)
        c, sine, fast, hit = np.cos(yaw), np.sin(yaw), np.abs(speed), s.hit
        gap, corner = gaps(x, y, c, sine), fast + self._hull.outer * np.abs(turn)
        added = np.where(gap < tight, SOLID * corner + MOVES * (corner > MOVING), 0.0)
        added += WALL * h * fast * np.minimum(np.maximum(NARROW - gap, 0.0), NARROW)
        if company is not None:
            k = slice(layer * PARTS + 1, (layer + 1) * PARTS + 1)
            close, hit = self._close(np.stack([x, y, c, sine]), speed, turn, hit, k, company)
            added += close
        cost += added.sum(axis=0)
        return _States(x[-1], y[-1], yaw[-1], reached, turning, cost, hit, s.held), np.stack([x, y, yaw])

    def _close(
        self, poses: Array, speed: Array, turn: Array, hit: Array, k: slice, company: _Company
    ) -> tuple[Array, Array]:
        """Costs of closeness and contacts, shape (PARTS, n), and the probabilities of contacts so far, (n, movers).

        Args:
            poses: x [m], y [m], cosine and sine of the yaw, world frame, shape (4, PARTS, n); they are changed.
            speed: Speed at each pose, forward positive [m/s], shape (PARTS, n).
            turn: Turn rate at each pose [rad/s], shape (PARTS, n).
            hit: Probabilities of contacts with each mover before, shape (n, movers).
            k: Predicted times of the poses.
            company: Predicted movers, m rows.
        """
        manners, hull = self._manners, self._hull
        at, outer = company.at[:, k], company.outer[:, k]
        reach = hull.outer + PASSING + float(outer.max())
        low, high = poses[:2].min(axis=(1, 2)) - reach, poses[:2].max(axis=(1, 2)) + reach
        near = ((at >= low) & (at <= high)).all(axis=-1).any(axis=1)
        if not near.any():
            return np.zeros_like(speed), hit
        # Single precision relative to a pose suffices, at half the time. Large buffers are used again, under new names.
        origin, weight = poses[:2, 0, 0].copy(), company.weight[near].astype(np.float32)
        there = (at[near] - origin).astype(np.float32).transpose(2, 1, 0)[..., None]  # (2, PARTS, m, 1)
        outer = outer[near].T[..., None].astype(np.float32)
        poses[:2] -= origin[:, None, None]
        x, y, c, s = poses.astype(np.float32)[:, :, None]
        dx, dy = there[0] - x, there[1] - y
        aside, part = c * dy, s * dx
        aside -= part
        ahead = np.multiply(c, dx, out=part)
        ahead += np.multiply(s, dy, out=dy)
        np.abs(ahead, out=ahead)
        ahead -= np.float32(0.5 * hull.length)
        beside = np.abs(aside, out=dx)
        beside -= np.float32(0.5 * hull.width)
        np.maximum(ahead, 0.0, out=ahead)
        np.maximum(beside, 0.0, out=beside)
        ahead *= ahead
        beside *= beside
        ahead += beside
        over = np.sqrt(ahead, out=ahead)  # the gap to the centre; 0 within the hull
        over -= outer
        soon = 1.0 / (1.0 + SOON * self._h * np.arange(k.start, k.stop))[:, None]
        cost = np.zeros_like(speed)
        part, row, state = np.nonzero(over < 0.0)
        if len(row):
            hit, mover, share = hit.copy(), company.mover[near][row], company.weight[near][row]
            to = there[:, part, row, 0] - poses[:2, part, state]
            turning = turn[part, state]
            nearer = self._nearer(to, poses[2:, part, state], speed[part, state], turning) + SLIP * np.abs(turning)
            # Towards the other the robot drives into it, also backwards; else the other strikes the robot.
            price = np.where(nearer < STAYING, STRUCK, DRIVEN + BY_SPEED * nearer)
            for j in range(len(cost)):
                now = part == j
                which, before, prices = (state[now], mover[now]), hit.copy(), np.zeros_like(hit)
                # The most probable hypothesis of a mover counts: their sum makes the robot too timid to get by.
                np.maximum.at(hit, which, share[now])
                np.maximum.at(prices, which, price[now])
                cost[j] = ((hit - before) * prices).sum(axis=1)  # a contact counts once, when it begins
            cost *= np.minimum(np.maximum(EDGE - over.min(axis=1) / DEPTH, LEAST), MOST)
        close = np.multiply(over, np.float32(-1.0 / manners.personal_space), out=dy)
        close += 1.0
        np.minimum(np.maximum(close, 0.0, out=close), 1.0, out=close)
        if manners.side != "either":
            wrong = aside < 0.0 if manners.side == "right" else aside > 0.0
            over *= np.float32(-1.0 / PASSING)
            over += 1.0
            np.minimum(np.maximum(over, 0.0, out=over), 1.0, out=over)
            over *= wrong
            over *= np.float32(WRONG_SIDE)
            close += over
        cost += CLOSE * self._h * (weight @ close) * (RESTING + speed * speed)
        return soon * cost, hit

    def _nearer(self, to: Array, facing: Array, speed: Array, turn: Array) -> Array:
        """Speed at which the hull moves towards points, of its point that is nearest to each of them [m/s], (n,).

        Args:
            to: Vectors from the middle of the hull to the points, world frame, shape (2, n) [m].
            facing: Cosines and sines of the yaw, shape (2, n).
            speed: Speeds [m/s], shape (n,).
            turn: Turn rates [rad/s], shape (n,).
        """
        hull, (c, s) = self._hull, facing
        x, y = c * to[0] + s * to[1], c * to[1] - s * to[0]
        at_x, at_y = np.clip(x, -0.5 * hull.length, 0.5 * hull.length), np.clip(y, -0.5 * hull.width, 0.5 * hull.width)
        inside = (at_x == x) & (at_y == y)
        dx, dy = np.where(inside, x, x - at_x), np.where(inside, y, y - at_y)
        nearer: Array = ((speed - turn * at_y) * dx + turn * at_x * dy) / np.maximum(np.hypot(dx, dy), 1e-3)
        return nearer

    def _rest(self, s: _States, before: _States, way: WayField) -> tuple[_States, Array]:
        """States (n) with their `held`, and the estimated cost of the way from them to the goal [s].

        Nobody drives through another: what lies behind a probable contact is no progress.
        """
        beyond = s.x + AHEAD * np.cos(s.yaw), s.y + AHEAD * np.sin(s.yaw)
        left, further = way.to_go(np.stack([s.x, beyond[0]]), np.stack([s.y, beyond[1]]))
        away = np.minimum(np.maximum((further - left) / AHEAD + 1.0, 0.0), 2.0)  # 0 along the way, 2 against it
        away *= np.minimum(np.maximum(left - NEAR_GOAL, 0.0), 1.0)
        # From a contact on, a plan has no less way left than where it began, by the share of its probability.
        held = np.where((s.hit > before.hit).any(axis=1), np.maximum(s.held, left), s.held)
        left = left + s.hit.max(axis=1, initial=0.0) * np.maximum(held - left, 0.0)
        cost = s.cost + LAYER * np.minimum(left / THERE, 1.0)  # time costs until it is there, so it never dawdles
        return s._replace(cost=cost, held=held), left / (PACE * self._limits.cruise) + AWAY * away

    def _different(self, s: _States, total: Array) -> npt.NDArray[np.intp]:
        """The cheapest states that differ from each other, in the order of their costs."""
        order = np.argsort(total, kind="stable")[: 6 * WIDTH]
        rows = [np.round(column[order] / step) for column, step in zip((s.x, s.y, s.yaw, s.v), KEY, strict=True)]
        # One number for the four, exact in a float and without collisions: |x| < 200 km, |y| < 12 km, speeds < 20 m/s.
        key = ((rows[0] * 100003.0 + rows[1]) * 1009.0 + rows[2]) * 101.0 + rows[3]
        _, first = np.unique(key, return_index=True)
        return order[np.sort(first)[:WIDTH]]


def _targets(
    limits: MotionLimits, turns: Sequence[float], ahead: Sequence[float], back: Sequence[float]
) -> tuple[Array, Array]:
    """Target speeds [m/s] and turn rates [rad/s] of a layer, as shares of the limits; each of shape (k,)."""
    rows = [(0.0, turn) for turn in (0.0, -1.0, 1.0)]
    rows += [(share, turn) for share in ahead for turn in turns]
    targets = np.array(rows) * (limits.cruise, limits.turn_rate)
    behind = np.array([(-share, BACK_TURN * turn) for share in back for turn in (0.0, -1.0, 1.0)])
    targets = np.vstack([targets, behind * (limits.back, limits.turn_rate)])
    fastest = np.abs(targets[:, 0]) + limits.arm * np.abs(targets[:, 1])
    v, w = (targets * np.minimum(1.0, limits.top / np.maximum(fastest, 1e-9))[:, None]).T
    return v.copy(), w.copy()
