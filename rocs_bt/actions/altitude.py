"""Altitude: height control of a flying body, beside the follower in the plane."""

from __future__ import annotations

import math

from ..action import ActionFailed, Body, Reason
from ..control.locomotion import Array
from .pose import PATIENCE

SETTLING = 3.0
"""Time constant of the approach to the height, in units of the body's lag [1]."""


class Altitude:
    """Vertical speed commands that lead to a height, with trapezoidal speed.

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
        self._command: float | None = None
        self._lost = 0

    def error(self) -> float:
        """Desired height minus the present one [m]; NaN while it is unknown."""
        return self._height - self._read("height")

    def added(self, values: Array) -> Array:
        """Values (m,) of a motion command with the vertical speed of this period.

        Raises:
            ActionFailed: LOST_SENSOR, if the height stays unknown.
        """
        error, climb = self.error(), self._read("climb")
        climb = climb if math.isfinite(climb) else self._command or 0.0
        before = climb if self._command is None else self._command
        if math.isfinite(error):
            self._lost = 0
            ahead = error - self._late * climb
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

    def _read(self, signal: str) -> float:
        signals, now = self._body.knowledge.signals, self._body.clock.now()
        return signals.value(signal, now) if signal in signals else math.nan
