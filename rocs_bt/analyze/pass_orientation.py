"""PassOrientation: whether the robot looks another way."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from ..channel import Signals, Stamped
from ..event import Change
from ..geometry import wrap_angle
from .analyze import Analyze


class PassOrientation(Analyze):
    """Tells Plan when the heading differs by more than `step` from the one it told last.

    Args:
        step: The difference that matters [rad].
    """

    def __init__(self, *args: Any, step: float = math.radians(45.0), **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._step = step
        self._told: float | None = None

    def expects(self) -> Sequence[str]:
        return ("pose",)

    def process(self, samples: Sequence[Stamped[Signals]]) -> Iterable[Change]:
        sample = next((s for s in reversed(samples) if "pose" in s.value), None)
        if sample is None or not math.isfinite(sample.value["pose"][2]):
            return
        yaw = sample.value["pose"][2]
        if self._told is None:
            self._told = yaw
        elif abs(wrap_angle(yaw - self._told)) > self._step:
            self._told = yaw
            yield self.change(sample.t, "turned", self.knowledge.agent, yaw=yaw)
