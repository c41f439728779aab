"""WheelMonitor: how fast the robot moves, from its wheel encoders."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..channel import Signals
from ..device import Reading
from ..signal import Signal
from ..units import LENGTH, SPEED, TURN_RATE
from .monitor import Monitor


class WheelMonitor(Monitor):
    """Writes `wheel_speeds`, `speed`, `turn_rate` and `stop_distance` from wheel rim speeds.

    `stop_distance` is what braking at the drive's full deceleration takes from the present speed, and what is driven
    meanwhile the robot reacts: v * latency + v^2 / (2 a).

    Args:
        latency: From a reading to wheels that begin to brake [s]; robot.toml has it measured.
    """

    def __init__(self, *args: Any, latency: float = 0.1, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self._latency = latency
        self._drive = self.knowledge.robot.drive

    def signals(self) -> Sequence[Signal]:
        wheels = len(self._drive.wheels)
        age = self.max_age
        return [
            Signal("wheel_speeds", wheels, (SPEED,) * wheels, (-1e3, 1e3), age, "Rim speeds in the drive's order."),
            Signal("speed", 1, (SPEED,), (-1e3, 1e3), age, "Forward speed of the body."),
            Signal("turn_rate", 1, (TURN_RATE,), (-1e3, 1e3), age, "Yaw rate of the body, left positive."),
            Signal("stop_distance", 1, (LENGTH,), (0.0, math.inf), age, "To stand still from the present speed."),
        ]

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        wheels = list(next(iter(readings.values())).values)
        twist = self._drive.twist(np.array(wheels))
        speed = abs(twist.forward)
        stop = speed * self._latency + speed * speed / (2.0 * self._drive.max_wheel_acceleration)
        return {
            "wheel_speeds": wheels,
            "speed": [twist.forward],
            "turn_rate": [twist.turn],
            "stop_distance": [stop],
        }
