"""OdometryMonitor: wheel travel from an odometer, and turn rate from a gyro."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ..base.signal import Signal
from ..base.units import LENGTH, TURN_RATE
from ..interfaces.channel import Signals
from ..interfaces.device import Reading
from .jump import JUMP, JumpDetector
from .monitor import Monitor

FARTHEST = 1e7
"""Largest plausible travel of a wheel [m]."""


class OdometryMonitor(Monitor):
    """Writes `wheel_travel` [m] from an odometer, and `gyro_rate` [rad/s] if the robot has a gyro.

    The travel counts from an arbitrary start; only differences are used, so a missed reading loses nothing. An odometer
    that jumps, such as one that is reset, is invalid until a later jump has undone the first.

    Attributes:
        odometer: Name of the odometer (travel of each wheel [m]).
        gyro: Name of the gyro (turn rate [rad/s]).
    """

    odometer: str = "odometer"
    gyro: str = "gyro"

    def __post_init__(self) -> None:
        self._has_gyro = any(each.sensor.name == self.gyro for each in self.monitored)
        locomotion = self.knowledge.robot.locomotion
        self._wheels = len(locomotion.wheels)
        self._jumps = [JumpDetector(limit, JUMP) for limit in locomotion.max_speed[: self._wheels]]

    def signals(self) -> Sequence[Signal]:
        travel = Signal(
            "wheel_travel",
            self._wheels,
            (LENGTH,),
            (-FARTHEST, FARTHEST),
            self.max_age,
            "Distance rolled by each wheel, in the drive's order.",
        )
        rate = Signal("gyro_rate", 1, (TURN_RATE,), (-1e3, 1e3), self.max_age, "Yaw rate by the gyro, left positive.")
        return [travel, rate] if self._has_gyro else [travel]

    def expects(self) -> Mapping[str, int]:
        return {self.odometer: self._wheels, **({self.gyro: 1} if self._has_gyro else {})}

    def reject(self, sensor: str, reading: Reading) -> str:
        if any(map(math.isinf, reading.values)):
            return "the reading is infinite"
        if sensor != self.odometer or any(map(math.isnan, reading.values)):
            return ""
        wheels = zip(self._jumps, reading.values, strict=True)
        return max((jump.reason([travel], reading.stamp) for jump, travel in wheels), default="")

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        names = {self.odometer: "wheel_travel", self.gyro: "gyro_rate"}
        return {signal: readings[name].values for name, signal in names.items() if name in readings}
