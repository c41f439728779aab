"""WheelMonitor: speeds of the robot and stop distance, from wheel encoders."""

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
"""Largest plausible wheel linear speed [m/s]."""


class WheelMonitor(Monitor):
    """Writes `wheel_speeds`, `speed`, `turn_rate` and `stop_distance` from measured wheel linear speeds.

    `stop_distance` is the reaction distance plus the braking distance at the present speed:
    v * latency + v^2 / (2 deceleration).

    Args:
        latency: Time from a reading until the wheels begin to brake [s], as measured in robot.toml.
        deceleration: Deceleration of braking wheels [m/s2], measured too; default: the drive's maximum acceleration.

    Raises:
        InputError: The latency is negative, or the deceleration is not positive.
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
                "wheel_speeds",
                wheels,
                (SPEED,) * wheels,
                (-FASTEST, FASTEST),
                age,
                "Wheel speeds in the drive's order.",
            ),
            Signal("speed", 1, (SPEED,), (-1e3, 1e3), age, "Forward speed of the body."),
            Signal("turn_rate", 1, (TURN_RATE,), (-1e3, 1e3), age, "Yaw rate of the body, left positive."),
            Signal("stop_distance", 1, (LENGTH,), (0.0, math.inf), age, "Distance to stop from the present speed."),
        ]

    def expects(self) -> Mapping[str, int]:
        return {self.monitored[0].sensor.name: len(self._drive.wheels)}

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        values = next(iter(readings.values())).values
        wheels = [v if abs(v) <= FASTEST else math.nan for v in values]
        twist = self._drive.twist(np.array(wheels))
        speed = abs(twist.forward)
        stop = speed * self._latency + speed * speed / (2.0 * self._deceleration)
        return {
            "wheel_speeds": values,
            "speed": [twist.forward],
            "turn_rate": [twist.turn],
            "stop_distance": [stop],
        }
