"""Altitude: height control of a flying body, beside the follower in the plane."""

from __future__ import annotations

import math
from collections import deque

from ..control.axis import AxisLimits
from ..control.locomotion import Array
from ..interfaces.action import ActionFailed, Body, Reason
from .pose import PATIENCE

SETTLING = 3.0
"""Time constant of the approach to the height, in units of the body's lag [1]."""

CLEARANCE = 0.15
"""Free range above and below that is kept on the way to a height [m]."""

MEMORY = 1.0
"""Time for which a range counts after its reading: a few beams do not detect everything in every period [s]."""

CLIMB_FIRST = 0.3
"""Height that is missing beyond which the robot climbs on the spot before it follows a path [m]."""


class Altitude:
    """Vertical speed commands that lead to a height, with trapezoidal speed, but not onto an obstacle.

    A robot with the ranges `above` or `below` stays `CLEARANCE` away from what they detect, and moves up and down so
    slowly that it stops within this distance. So it descends only behind an obstacle over which a reflex has taken it.
    A landing is not commanded by height.

    Args:
        body: Flying robot; Knowledge has its `height`.
        height: Desired height [m].
    """

    def __init__(self, body: Body, height: float) -> None:
        locomotion = body.locomotion
        self._body = body
        self._height = height
        self._index = locomotion.values.index("vz")
        self._axis = locomotion.axis_limits("vz")
        self._late = locomotion.response.late
        self._above, self._below = _Edge(body, "above", 1.0), _Edge(body, "below", -1.0)
        if self._above.known or self._below.known:
            change = self._axis.max_acceleration
            reaction = change * locomotion.response.latency
            stoppable = math.sqrt(reaction * reaction + 2.0 * change * CLEARANCE) - reaction
            self._axis = AxisLimits(min(self._axis.max_speed, stoppable), change)
        self._command: float | None = None
        self._lost = 0

    def error(self) -> float:
        """Desired height minus the present one [m]; NaN while it is unknown."""
        return self._height - self._read("height")

    def climbs_first(self) -> bool:
        """Whether the robot must climb before it moves on; it descends while it moves."""
        height = self._read("height")
        return self._reachable(height) - height > CLIMB_FIRST

    def added(self, values: Array) -> Array:
        """Values (m,) of a motion command with the vertical speed of this period.

        Raises:
            ActionFailed: LOST_SENSOR, if the height stays unknown.
        """
        height, climb = self._read("height"), self._read("climb")
        climb = climb if math.isfinite(climb) else self._command or 0.0
        before = climb if self._command is None else self._command
        if math.isfinite(height):
            self._lost = 0
            ahead = self._reachable(height) - height - self._late * climb
            self._command = self._axis.step(ahead, before, self._body.period, settling=SETTLING * self._late)
        else:
            self._lost += 1
            if self._lost > PATIENCE:
                seconds = self._lost * self._body.period
                raise ActionFailed(Reason.LOST_SENSOR, f"the signal 'height' has been invalid for {seconds:.2f} s")
            self._command = 0.0
        raised = values.copy()
        raised[self._index] = self._command
        return raised

    def _reachable(self, height: float) -> float:
        """Desired height, limited by what is above and below; the middle of a gap that is too narrow [m]."""
        highest, lowest = self._above.read(height) - CLEARANCE, self._below.read(height) + CLEARANCE
        return 0.5 * (lowest + highest) if lowest > highest else min(max(self._height, lowest), highest)

    def _read(self, signal: str) -> float:
        signals, now = self._body.knowledge.signals, self._body.clock.now()
        return signals.value(signal, now) if signal in signals else math.nan


class _Edge:
    """Height of the nearest thing above (sign 1) or below (-1) the robot, from ranges of the last `MEMORY`."""

    def __init__(self, body: Body, group: str, sign: float) -> None:
        self._signals, self._clock = body.knowledge.signals, body.clock
        self._group, self._sign = group, sign
        self._found: deque[tuple[float, float]] = deque()  # times and heights, nearest first
        self.known = group in self._signals

    def read(self, height: float) -> float:
        """Height of the thing [m], -inf or +inf without one; an invalid range permits no motion in its direction.

        Args:
            height: Present height of the robot [m].
        """
        if not self.known:
            return math.copysign(math.inf, self._sign)
        now, sign, found = self._clock.now(), self._sign, self._found
        ranges = self._signals.numbers(self._group, now)
        free = CLEARANCE if any(map(math.isnan, ranges)) else min(ranges)
        edge = height + sign * free
        while found and sign * found[-1][1] >= sign * edge:
            found.pop()
        found.append((now, edge))
        while found[0][0] < now - MEMORY:
            found.popleft()
        return found[0][1]
