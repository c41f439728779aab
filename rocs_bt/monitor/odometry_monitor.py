"""OdometryMonitor: how far the wheels have rolled, and how fast a gyro says that the robot turns."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from ..channel import Signals
from ..device import Reading
from ..signal import Signal
from ..units import LENGTH, TURN_RATE
from .monitor import Monitor

FARTHEST = 1e7
"""A wheel that has rolled farther is no wheel but a fault [m]."""


class OdometryMonitor(Monitor):
    """Writes `wheel_travel` [m] from an odometer, and `gyro_rate` [rad/s] where the robot has a gyro.

    Travel counts from any start: only its growth means something, so a reading that is missed costs nothing.

    Args:
        odometer: The odometer's name.
        gyro: The gyro's name.
    """

    def __init__(self, *args: Any, odometer: str = "odometer", gyro: str = "gyro", **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._odometer = odometer
        self._gyro = gyro
        self._has_gyro = any(watched.sensor.name == gyro for watched in self.watched)
        self._wheels = len(self.knowledge.robot.drive.wheels)

    def signals(self) -> Sequence[Signal]:
        travel = Signal(
            "wheel_travel",
            self._wheels,
            (LENGTH,),
            (-FARTHEST, FARTHEST),
            self.max_age,
            "How far each wheel has rolled, in the drive's order.",
        )
        rate = Signal("gyro_rate", 1, (TURN_RATE,), (-1e3, 1e3), self.max_age, "Yaw rate by the gyro, left positive.")
        return [travel, rate] if self._has_gyro else [travel]

    def expects(self) -> Mapping[str, int]:
        return {self._odometer: self._wheels, **({self._gyro: 1} if self._has_gyro else {})}

    def doubt(self, sensor: str, reading: Reading) -> str:
        return "it says infinity" if any(map(math.isinf, reading.values)) else ""

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        names = {self._odometer: "wheel_travel", self._gyro: "gyro_rate"}
        return {signal: list(readings[name].values) for name, signal in names.items() if name in readings}
