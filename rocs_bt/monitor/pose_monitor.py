"""PoseMonitor: pose of the robot and distance to its goal."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from ..base.geometry import wrap_angle
from ..base.signal import Signal
from ..base.units import ANGLE, LENGTH
from ..event import Change
from ..interfaces.channel import Signals
from ..interfaces.device import Reading
from .jump import JUMP, TURN_JUMP, JumpDetector
from .monitor import MOVING, Monitor

FARTHEST = 1e6
"""Largest plausible coordinate [m]."""

TURNING = 0.1
"""Turn rate above which consecutive orientations must differ [rad/s]."""


class PoseMonitor(Monitor):
    """Writes `pose` [m, m, rad] and `goal_distance` [m] from a position sensor and an orientation sensor.

    The goal is the pursued node in Knowledge; without one the distance is +inf.

    The frame of odometry is continuous (REP 105). A sensor in such a frame that jumps is invalid, until a later jump
    has undone the first: its frame is no longer that of the goals. A jump of a localiser is reported as a Change.

    Attributes:
        position: Name of the position sensor (x, y and optional further values [m], world frame).
        orientation: Name of the orientation sensor (yaw [rad]).
        continuous: If False, neither sensor is in a continuous frame, as of a localiser. If True, it depends on the
            driver: `SensorSpec.frame`.
    """

    position: str = "position"
    orientation: str = "orientation"
    continuous: bool = True

    def __post_init__(self) -> None:
        self._frames = {
            each.sensor.name: "corrected" if each.frame and not self.continuous else each.frame
            for each in self.monitored
        }
        limits = self.knowledge.robot.locomotion
        self._jumps = {
            each: JumpDetector(limits.speed_limit, JUMP)
            if each == self.position
            else JumpDetector(limits.turn_limit, TURN_JUMP, math.tau)
            for each in self._frames
        }
        self._latest: dict[str, Reading] = {}

    def stamp(self, readings: Mapping[str, Reading]) -> float:
        return min(self._latest[self.position].stamp, self._latest[self.orientation].stamp)

    def reject(self, sensor: str, reading: Reading) -> str:
        if any(map(math.isinf, reading.values)):
            return "the reading is infinite"
        values = reading.values[:2] if sensor == self.position else reading.values[:1]
        if not self._frames[sensor] or any(map(math.isnan, values)):
            return ""
        if self._frames[sensor] == "continuous":
            return self._jumps[sensor].reason(values, reading.stamp)
        if size := self._jumps[sensor].after(values, reading.stamp)[0]:
            change = Change(
                t=self.knowledge.clock.now(),
                agent=self.knowledge.agent,
                source=self.name,
                kind="jumped",
                subject=sensor,
                values={"size": size},
            )
            self._sink.emit(change)
        return ""

    def varies(self, sensor: str) -> bool:
        """Whether the robot drives (for a position) or turns (for an orientation)."""
        twist = self.knowledge.robot.locomotion.twist(self.knowledge.robot.motion())
        return (
            abs(twist.turn) > TURNING if sensor == self.orientation else math.hypot(twist.forward, twist.left) > MOVING
        )

    def signals(self) -> Sequence[Signal]:
        return [
            Signal(
                "pose", 3, (LENGTH, LENGTH, ANGLE), (-FARTHEST, FARTHEST), self.max_age, "x, y, yaw in the world frame."
            ),
            Signal(
                "goal_distance",
                1,
                (LENGTH,),
                (0.0, math.inf),
                self.max_age,
                "Distance to the pursued goal; +inf without.",
            ),
        ]

    def expects(self) -> Mapping[str, int]:
        return {self.position: 3, self.orientation: 1}

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        self._latest.update(readings)
        if self.position not in self._latest or self.orientation not in self._latest:
            return {}
        if self.position not in readings and self.orientation not in readings:
            return {}
        x, y = self._latest[self.position].values[:2]
        yaw = self._latest[self.orientation].values[0]
        world = self.knowledge.world
        pursued = world.pursued()
        goal = world.pose_of(pursued) if pursued is not None else None
        distance = math.inf if goal is None else math.hypot(goal.x - x, goal.y - y)
        if max(abs(x), abs(y)) > FARTHEST or not math.isfinite(x + y):
            distance = math.nan  # +inf would mean that there is no goal
        return {"pose": [x, y, wrap_angle(yaw) if math.isfinite(yaw) else math.nan], "goal_distance": [distance]}


class FixMonitor(Monitor):
    """Writes `fix` [m] from a position sensor and `compass` [rad] from an orientation sensor, each when it is read.

    These signals are not accurate enough for driving; Localise estimates the pose from them.

    Attributes:
        position: Name of the position sensor (x, y and optional further values [m], world frame).
        orientation: Name of the orientation sensor (yaw [rad]).
    """

    position: str = "position"
    orientation: str = "orientation"

    def signals(self) -> Sequence[Signal]:
        age = self.max_age
        return [
            Signal("fix", 2, (LENGTH,), (-FARTHEST, FARTHEST), age, "x, y of a position fix in the world frame."),
            Signal("compass", 1, (ANGLE,), (-math.pi, math.pi), age, "Heading by the compass in the world frame."),
        ]

    def expects(self) -> Mapping[str, int]:
        return {self.position: 3, self.orientation: 1}

    def reject(self, sensor: str, reading: Reading) -> str:
        return "the reading is infinite" if any(map(math.isinf, reading.values)) else ""

    def interpret(self, readings: Mapping[str, Reading]) -> Signals:
        found: dict[str, list[float]] = {}
        if (position := readings.get(self.position)) is not None:
            found["fix"] = list(position.values[:2])
        if (orientation := readings.get(self.orientation)) is not None:
            yaw = orientation.values[0]
            found["compass"] = [wrap_angle(yaw) if math.isfinite(yaw) else math.nan]
        return found
