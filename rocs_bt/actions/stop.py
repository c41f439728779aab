"""Stop: brake to standstill."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import numpy as np

from ..base.units import NOT_NEGATIVE, MetresPerSecond, PositiveSeconds
from ..interfaces.action import AtomicAction, Body, Failure, Progress


class Stop(AtomicAction):
    """Command the body not to move until it is stationary: wheels brake, legs do not step, and a flying body hovers.

    A body that hovers lands when it has not been commanded to move for a time. A body that drifts, such as a boat in a
    current, is never stationary, and the action does not end.

    Attributes:
        below: Speed below which a wheel, or an axis of another body, counts as stationary [m/s, rad/s].
        patience: Duration of the command if the speeds are unknown [s].
    """

    below: Annotated[MetresPerSecond, NOT_NEGATIVE] = 0.02
    patience: PositiveSeconds = 1.0
    _begun: float | None = None

    @classmethod
    def can_move(cls, parameters: Mapping[str, Any]) -> bool:
        return False

    def act(self, body: Body) -> Progress | Failure:
        now = body.clock.now()
        if self._begun is None:
            self._begun = now
        body.rest()
        speeds = body.knowledge.robot.motion()
        if np.isfinite(speeds).all():
            stationary = bool(np.abs(speeds).max(initial=0.0) < self.below)
        else:
            stationary = now - self._begun >= self.patience
        return Progress.SUCCEEDED if stationary else Progress.RUNNING
