"""MotionMonitor: motion, tilt and height of a body, from sensors that measure them directly."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ..base.errors import Fault, InputError
from ..base.geometry import Twist3
from ..base.signal import Signal
from ..interfaces.channel import Signals
from ..interfaces.device import Reading
from .course import course_signals, declared, motion_signals, motion_values
from .jump import JUMP, JumpDetector
from .monitor import Monitor


class MotionMonitor(Monitor):
    """Writes the motion of a body without wheel encoders, and the tilt and the height of any body.

    A twist sensor gives `speed`, `turn_rate` and `stop_distance`, and for bodies that move sideways or vertically
    `course_speed`, `lateral_speed` and `climb`. An attitude sensor gives `tilt`, a height sensor `height`. At least one
    of the three sensors is needed. A height in a continuous frame that jumps is invalid, as the pose of a PoseMonitor.

    Attributes:
        twist: Name of the twist sensor (forward, left, up [m/s], turn [rad/s]).
        attitude: Name of the attitude sensor (roll, pitch [rad]).
        height: Name of the height sensor [m].

    Raises:
        InputError: The monitor has none of these sensors.
    """

    twist: str = "twist"
    attitude: str = "attitude"
    height: str = "height"

    def __post_init__(self) -> None:
        named = {each.sensor.name for each in self.monitored}
        sizes = {self.twist: 4, self.attitude: 2, self.height: 1}
        self._sizes_of = {name: size for name, size in sizes.items() if name in named}
        if not self._sizes_of:
            found = ", ".join(sorted(named)) or "none"
            wanted = f"'{self.twist}', '{self.attitude}' or '{self.height}'"
            message = f"monitor '{self.name}' needs a sensor {wanted}, found {found}."
            raise InputError(Fault(message, hint="Its parameters twist, attitude and height name its sensors."))
        self._locomotion = self.knowledge.robot.locomotion
        self._course = course_signals(self._locomotion)
        upward = self._locomotion.axis_limits("vz" if "vz" in self._locomotion.axes else "vx").max_speed
        continuous = any(m.sensor.name == self.height and m.frame == "continuous" for m in self.monitored)
        self._jumps = JumpDetector(upward, JUMP) if continuous else None

    def signals(self) -> Sequence[Signal]:
        age, found = self.max_age, list[Signal]()
        if self.twist in self._sizes_of:
            found += motion_signals(self._course, age)
        tilt_and_height = {self.attitude: "tilt", self.height: "height"}
        return found + declared([signal for name, signal in tilt_and_height.items() if name in self._sizes_of], age)

    def expects(self) -> Mapping[str, int]:
        return self._sizes_of

    def reject(self, sensor: str, reading: Reading) -> str:
        if any(map(math.isinf, reading.values)):
            return "the reading is infinite"
        if sensor != self.height or self._jumps is None or math.isnan(reading.values[0]):
            return ""
        return self._jumps.reason(reading.values, reading.stamp)

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        written: dict[str, Sequence[float]] = {}
        if self.twist in readings:
            written |= motion_values(self._locomotion, Twist3(*readings[self.twist].values), self._course)
        if self.attitude in readings:
            roll, pitch = readings[self.attitude].values
            written["tilt"] = [math.acos(math.cos(roll) * math.cos(pitch))]
        if self.height in readings:
            written["height"] = readings[self.height].values
        return written
