"""WheelMonitor: how fast the robot moves, from its wheel encoders."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..channel import Signals
from ..device import Reading
from ..errors import Fault, InputError
from ..signal import Signal
from ..units import LENGTH, SPEED, TURN_RATE
from .monitor import Monitor

FASTEST = 1e3
"""A rim speed beyond this is no speed but a fault [m/s]."""


class WheelMonitor(Monitor):
    """Writes `wheel_speeds`, `speed`, `turn_rate` and `stop_distance` from wheel rim speeds.

    `stop_distance` is what braking takes from the present speed, and what is driven meanwhile the robot reacts:
    v * latency + v^2 / (2 deceleration).

    Args:
        latency: From a reading to wheels that begin to brake [s]; robot.toml has it measured.
        deceleration: Of braking wheels [m/s2], measured too; the drive's greatest acceleration by default.
    """

    def __init__(self, *args: Any, latency: float = 0.1, deceleration: float = math.nan, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._latency = latency
        self._drive = self.knowledge.robot.drive
        self._deceleration = self._drive.max_wheel_acceleration if math.isnan(deceleration) else deceleration
        if not (self._latency >= 0.0 and self._deceleration > 0.0):
            raise InputError(
                Fault(
                    f"monitor '{self.name}' needs a latency of 0 s or more and a deceleration above 0 m/s2, found "
                    f"{latency} s and {deceleration} m/s2."
                )
            )

    def signals(self) -> Sequence[Signal]:
        wheels = len(self._drive.wheels)
        age = self.max_age
        return [
            Signal(
                "wheel_speeds", wheels, (SPEED,) * wheels, (-FASTEST, FASTEST), age, "Rim speeds in the drive's order."
            ),
            Signal("speed", 1, (SPEED,), (-1e3, 1e3), age, "Forward speed of the body."),
            Signal("turn_rate", 1, (TURN_RATE,), (-1e3, 1e3), age, "Yaw rate of the body, left positive."),
            Signal("stop_distance", 1, (LENGTH,), (0.0, math.inf), age, "To stand still from the present speed."),
        ]

    def expects(self) -> Mapping[str, int]:
        return {self.watched[0].sensor.name: len(self._drive.wheels)}

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        said = next(iter(readings.values())).values
        wheels = [v if abs(v) <= FASTEST else math.nan for v in said]
        twist = self._drive.twist(np.array(wheels))
        speed = abs(twist.forward)
        stop = speed * self._latency + speed * speed / (2.0 * self._deceleration)
        return {
            "wheel_speeds": said,
            "speed": [twist.forward],
            "turn_rate": [twist.turn],
            "stop_distance": [stop],
        }
