"""Every simulated device measures and moves the same in MuJoCo and in the flat world."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.devices.mujoco import MujocoWorld, RobotInstance, SensorMount, compose_world
from rocs_bt.devices.simulated import ACTUATORS, SENSORS, Velocity
from rocs_bt.devices.simulated.flat import FlatRobot, FlatWorld
from rocs_bt.interfaces.message import ReceivedMessage
from tests.made_devices import keys

ROBOT = Catalog().load_robot("pioneer_p3dx")
SITES = tuple(f"sonar{i}" for i in range(16))
MOTORS = {"motors": ["left_motor", "right_motor"], "wheel_radius": 0.0975}
KEYS: dict[str, dict[str, Any]] = {
    "range_cone": {"sites": SITES, "range": [0.1, 2.5], "half_angle": 0.2, "rays": 5},
    "lidar": {"site": "lidar", "rays": 61, "span": 4.0, "range": [0.1, 8.0]},
    "robot_sensor": {"max_range": 9.0, "max_peers": 2},
    "wheel_speed": MOTORS,
    "wheel_travel": {**MOTORS, "counts": 4096},
    "battery": {"capacity": 100.0, "idle_power": 10.0, "motion_power": 20.0},
}
DRIVEN = {"twist", "wheel_speed", "wheel_travel", "gyro"}
START, OTHER = Pose2(0.3, -0.2, 0.5), Pose2(-2.5, 1.0, 0.0)
ARENA = """<mujoco><worldbody><geom name="floor" type="plane" size="9 9 1"/>
<geom name="wall" type="box" size="0.001 1.5 1" pos="2 0 1"/>
<geom name="post" type="cylinder" size="0.2 1" pos="0.6 1 1"/>
</worldbody></mujoco>"""


@pytest.fixture
def scenes(tmp_path) -> tuple[MujocoWorld, FlatWorld]:
    """The same robots and obstacles in both."""
    (tmp_path / "arena.xml").write_text(ARENA)
    text = ROBOT.model.read_text()
    (tmp_path / "robot.xml").write_text(
        text.replace('<site name="sonar0"', '<site name="lidar" pos="0.1 0 0.3"/><site name="sonar0"')
    )
    mounts = [SensorMount(driver, keys(driver, driver, KEYS.get(driver, {}))) for driver in SENSORS]
    robots = [RobotInstance(name, tmp_path / "robot.xml", mounts) for name in ("R1", "R2")]
    real = compose_world(tmp_path / "arena.xml", robots)
    flat = FlatWorld(SimulatedClock(0.05), segments=[((2, -1.5), (2, 1.5))], circles=[((0.6, 1.0), 0.2)])
    sites = {site: Pose2(*real.direction("R1", site, "z")[:3]) for site in SITES} | {"lidar": Pose2(0.1, 0.0)}
    for name, pose in (("R1", START), ("R2", OTHER)):
        FlatRobot(flat, ROBOT.locomotion, pose, sites, dict.fromkeys(MOTORS["motors"], 0.0975))
        real.place(name, pose)
    return real, flat


@pytest.mark.parametrize("driver", SENSORS)
def test_a_sensor_reads_the_same(scenes, driver: str) -> None:
    real, flat = scenes
    assert set(ACTUATORS) == {"velocity"}
    sensors = [keys(driver, driver, KEYS.get(driver, {})).bind(driver, world, "R1") for world in scenes]
    before = [sensor.read().values for sensor in sensors]
    assert len(before[0]) == len(before[1])
    wheels = [Velocity(motors=("left_motor", "right_motor"), wheel_radius=0.0975).bind("w", s, "R1") for s in scenes]
    for _ in range(40):
        for each in wheels:
            each.command([0.2, 0.3])
        real.advance(10)
        flat.advance(0.05)
        flat.clock.advance()
        found = [sensor.read().values for sensor in sensors] if driver == "gyro" else []  # a mean since the last one
    body = flat.robots["R1"]
    assert body.pose.distance(real.pose("R1")) < 0.02
    body.pose = real.pose("R1") if driver not in DRIVEN else body.pose
    if driver == "mailbox":
        for sensor in sensors:
            sensor.message_queue.put(ReceivedMessage("R2", "hello"))
    found = found or [sensor.read().values for sensor in sensors]
    one, other = (np.array(values) for values in found)
    if driver in ("position", "height"):
        one[-1] -= real.pose3("R1").z  # the flat world has no height
    assert len(one) == len(other) == (keys(driver, driver, KEYS.get(driver, {})).size or len(one)) > 0
    assert one == pytest.approx(other, abs=0.02)
    assert one.tolist() != before[0] or driver in ("attitude", "height")
    assert math.isfinite(one.min())
