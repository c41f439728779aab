"""WheelMonitor: speeds of the robot and stop distance, from wheel encoders."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from ..base.errors import Fault, InputError
from ..base.signal import Signal
from ..base.units import SPEED
from ..interfaces.channel import Signals
from ..interfaces.device import Reading
from .course import course_signals, motion_signals, motion_values
from .monitor import Monitor

FASTEST = 1e3
"""Largest plausible wheel linear speed [m/s]."""


class WheelMonitor(Monitor):
    """Writes `wheel_speeds`, `speed`, `turn_rate` and `stop_distance` from measured wheel linear speeds.

    `stop_distance` is the reaction distance plus the braking distance at the present speed, by the latency and the
    deceleration in `[locomotion]`: v * latency + v^2 / (2 deceleration). Robots that move sideways also have
    `course_speed` and `lateral_speed`.

    Raises:
        InputError: The robot has no wheels.
    """

    def __post_init__(self) -> None:
        self._locomotion = self.knowledge.robot.locomotion
        self._course = course_signals(self._locomotion)
        if not self._locomotion.wheels:
            raise InputError(Fault(f"monitor '{self.name}': a '{self._locomotion.kind}' locomotion has no wheels."))

    def signals(self) -> Sequence[Signal]:
        wheels = len(self._locomotion.wheels)
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
            *motion_signals(self._course, age),
        ]

    def expects(self) -> Mapping[str, int]:
        return {self.monitored[0].sensor.name: len(self._locomotion.wheels)}

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        values = next(iter(readings.values())).values
        wheels = [v if abs(v) <= FASTEST else math.nan for v in values]
        twist = self._locomotion.twist(np.array(wheels))
        return {"wheel_speeds": values, **motion_values(self._locomotion, twist, self._course)}
