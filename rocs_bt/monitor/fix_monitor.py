"""FixMonitor: position and heading fixes from slow, noisy, absolute sensors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ..base.geometry import wrap_angle
from ..base.signal import Signal
from ..base.units import ANGLE, LENGTH
from ..interfaces.channel import Signals
from ..interfaces.device import Reading
from .monitor import Monitor
from .pose_monitor import FARTHEST


class FixMonitor(Monitor):
    """Writes `fix` [m] from a position sensor and `compass` [rad] from an orientation sensor, each when it is read.

    These signals are not accurate enough for driving; Localise estimates the pose from them.

    Args:
        position: Name of the position sensor (x, y and optional further values [m], world frame).
        orientation: Name of the orientation sensor (yaw [rad]).
    """

    def __init__(self, *args: Any, position: str = "position", orientation: str = "orientation", **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._position = position
        self._orientation = orientation

    def signals(self) -> Sequence[Signal]:
        age = self.max_age
        return [
            Signal("fix", 2, (LENGTH,), (-FARTHEST, FARTHEST), age, "x, y of a position fix in the world frame."),
            Signal("compass", 1, (ANGLE,), (-math.pi, math.pi), age, "Heading by the compass in the world frame."),
        ]

    def expects(self) -> Mapping[str, int]:
        return {self._position: 3, self._orientation: 1}

    def reject(self, sensor: str, reading: Reading) -> str:
        return "the reading is infinite" if any(map(math.isinf, reading.values)) else ""

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        found: dict[str, list[float]] = {}
        if (position := readings.get(self._position)) is not None:
            found["fix"] = list(position.values[:2])
        if (orientation := readings.get(self._orientation)) is not None:
            yaw = orientation.values[0]
            found["compass"] = [wrap_angle(yaw) if math.isfinite(yaw) else math.nan]
        return found
