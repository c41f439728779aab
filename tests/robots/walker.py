"""A legged robot with its gait alone on a floor, for tests of its motion."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from rocs_bt.base.geometry import Twist2, wrap_angle
from rocs_bt.catalog import Catalog, RobotSpec
from rocs_bt.devices.mujoco import MujocoWorld, RobotInstance, compose_world
from tests.made_devices import make_device

CATALOG = Catalog()
STEP = 0.005  # [s]


class Walker:
    """A legged robot alone on a floor.

    Args:
        name: Name of the robot, whose gait is in `gait.py`.
        folder: Folder for the arena.
        geoms: Further geoms of the arena, MJCF.
    """

    def __init__(self, name: str, folder: Path, geoms: str = "") -> None:
        spec: RobotSpec = CATALOG.load_robot(name)
        assert spec.model is not None
        arena = folder / "arena.xml"
        floor = '<geom name="floor" type="plane" size="0 0 1"/>'
        arena.write_text(f"<mujoco><worldbody>{floor}{geoms}</worldbody></mujoco>")
        self.world: MujocoWorld = compose_world(arena, [RobotInstance("R", spec.model)], step=STEP)
        self.locomotion = spec.locomotion
        gait = CATALOG.load_class(spec.file.parent / "gait.py", "Gait")
        self.gait = make_device(self.world, "R", "gait", gait, {})
        self.world.attach(self.gait.before_step)
        self.tilt = 0.0

    def go(self, twist: Twist2, seconds: float) -> None:
        """Walk with a twist."""
        self.gait.command(self.locomotion.command(twist).tolist())
        self.wait(seconds)

    def wait(self, seconds: float) -> None:
        """Let the world run on."""
        for _ in range(round(seconds / 0.05)):
            self.world.advance(10)
            self.tilt = max(self.tilt, self.world.tilt("R"))

    def push(self, force: float, angle: float) -> None:
        """Push the trunk horizontally for 0.1 s."""
        trunk = self.world.body("R").root
        self.world.data.xfrc_applied[trunk, :2] = force * math.cos(angle), force * math.sin(angle)
        self.world.advance(round(0.1 / STEP))
        self.world.data.xfrc_applied[trunk] = 0.0

    def mean_twist(self, seconds: float) -> Twist2:
        """Mean twist while the world runs on."""
        moved, turned = np.zeros(2), 0.0
        for _ in range(round(seconds / 0.02)):
            before = self.world.pose("R")
            self.world.advance(4)
            after = self.world.pose("R")
            yaw = before.yaw + 0.5 * wrap_angle(after.yaw - before.yaw)
            dx, dy = after.x - before.x, after.y - before.y
            moved += (math.cos(yaw) * dx + math.sin(yaw) * dy, math.cos(yaw) * dy - math.sin(yaw) * dx)
            turned += wrap_angle(after.yaw - before.yaw)
        forward, left = (moved / seconds).tolist()
        return Twist2(forward, turned / seconds, left)

    @property
    def upright(self) -> bool:
        """Whether it is on its feet and level."""
        return self.world.tilt("R") < math.radians(15.0) and not self.world.ground_contact("R")
