"""Stop: brake to standstill."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Any

import numpy as np

from ..action import AtomicAction, Body, Failure, Progress
from ..units import NOT_NEGATIVE, MetresPerSecond, PositiveSeconds


@dataclass(kw_only=True, eq=False)
class Stop(AtomicAction):
    """Command zero wheel speeds until the wheels are stationary.

    Attributes:
        below: Wheel linear speed below which a wheel counts as stationary [m/s].
        patience: Duration of the command if the wheel speeds are unknown [s].
    """

    below: Annotated[MetresPerSecond, NOT_NEGATIVE] = 0.02
    patience: PositiveSeconds = 1.0
    _begun: float | None = field(default=None, init=False, repr=False)

    @classmethod
    def can_move(cls, parameters: Mapping[str, Any]) -> bool:
        return False

    def act(self, body: Body) -> Progress | Failure:
        now = body.clock.now()
        if self._begun is None:
            self._begun = now
        body.wheels.command([0.0] * len(body.drive.wheels))
        speeds = body.knowledge.robot.wheel_speeds()
        if np.isfinite(speeds).all():
            stationary = bool(np.abs(speeds).max(initial=0.0) < self.below)
        else:
            stationary = now - self._begun >= self.patience
        return Progress.SUCCEEDED if stationary else Progress.RUNNING
