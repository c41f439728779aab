from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
import pytest

from rocs_bt.base.geometry import Pose2, Twist2
from rocs_bt.control.locomotion import Locomotion
from rocs_bt.control.locomotion_kinds import make_locomotion

PERIOD = 0.05
LIMITS = {"max_wheel_speed": 1.2, "max_wheel_acceleration": 1.5}
LOCOMOTIONS = {
    "differential": make_locomotion("differential", wheel_separation=0.33, **LIMITS),
    "skid": make_locomotion("skid", effective_wheel_separation=1.0, **LIMITS),
    "mecanum": make_locomotion("mecanum", half_length=0.22, half_width=0.2, **LIMITS),
    "omni3": make_locomotion("omni3", base_radius=0.2, **LIMITS),
}


@pytest.fixture
def drive() -> Locomotion:
    """A P3DX-like differential drive."""
    return LOCOMOTIONS["differential"]


@pytest.fixture(params=sorted(LOCOMOTIONS))
def any_drive(request: pytest.FixtureRequest) -> Locomotion:
    """Every kind of drive in turn."""
    return LOCOMOTIONS[request.param]


class Plant:
    """Wheels that lag behind their command, turns and sideways motion that slip."""

    def __init__(
        self, drive: Locomotion, pose: Pose2, lag: float = 0.04, slip: float = 0.97, left: float = 1.0
    ) -> None:
        self.locomotion, self.pose, self.lag, self.slip, self.left = drive, pose, lag, slip, left
        self.wheels = np.zeros(len(drive.wheels))

    @property
    def twist(self) -> Twist2:
        return self.locomotion.twist(self.wheels)

    def move(self, command: npt.NDArray[np.float64], period: float = PERIOD) -> None:
        for _ in range(10):
            self.wheels = self.wheels + (command - self.wheels) * (1.0 - math.exp(-0.1 * period / self.lag))
            twist, dt = self.twist, 0.1 * period
            turned = dt * self.slip * twist.turn
            ahead = Pose2(self.pose.x, self.pose.y, self.pose.yaw + 0.5 * turned)
            self.pose = Pose2(
                *ahead.transform(dt * twist.forward, dt * self.left * twist.left), ahead.yaw + 0.5 * turned
            )
