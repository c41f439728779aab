"""Odometers and gyros: whole counts, means, and the same in MuJoCo and in the mock."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.devices.mujoco import MujocoWorld
from rocs_bt.devices.simulated.flat import FlatRobot, FlatWorld
from tests.made_devices import make_device

MOTORS = {"motors": ["left_motor", "right_motor"], "wheel_radius": 0.0975}
ODOMETER = {**MOTORS, "counts": 1000}
COUNT = math.tau * 0.0975 / 1000
DRIVE = make_locomotion("differential", wheel_separation=0.331, max_wheel_speed=1.2, max_wheel_acceleration=1.5)


def test_travel_is_in_whole_counts_and_grows_without_end() -> None:
    robot = FlatRobot(FlatWorld(SimulatedClock(0.05)), DRIVE, Pose2(0.0, 0.0), {}, {"a": 0.1, "b": -0.1})
    given = {"motors": ["a", "b"], "wheel_radius": 0.1, "signs": [1, -1], "counts": 8}
    sensor, eighth = make_device(robot.world, robot.name, "o", "wheel_travel", given), 0.1 * math.tau / 8.0
    robot.wheel_travel = [0.99 * eighth, 0.01 * eighth]
    assert sensor.sample() == pytest.approx([0.0, eighth])
    robot.wheel_travel = [100.5 * eighth, -0.5 * eighth]
    assert sensor.sample() == pytest.approx([100.0 * eighth, 0.0])


def test_a_wheel_that_slips_has_rolled_all_the_same(make_world: Callable[..., MujocoWorld]) -> None:
    world = make_world('<geom name="wall" type="box" size="0.05 2 0.3" pos="0.3 0 0.3"/>')
    world.place("R2", Pose2(0.0, 0.0))
    odometer = make_device(world, "R2", "o", "wheel_travel", ODOMETER)
    wheels = make_device(world, "R2", "wheels", "velocity", MOTORS)
    for _ in range(100):
        wheels.command([0.5, 0.5])
        world.advance(10)
    assert min(odometer.read().values) > 1.0
    assert world.pose("R2").x < 0.2


def test_a_gyro_has_one_bias_for_life_and_noise_of_its_own(make_world: Callable[..., MujocoWorld]) -> None:
    world, biases, spreads = make_world(), [], []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        gyro = make_device(world, "R2", "g", "gyro", {"bias_noise": 0.1}, noise=0.02, rng=rng)
        said = []
        for _ in range(30):
            said.append(gyro.read().values[0])
            assert gyro.read().values[0] == said[-1]
            world.advance(1)
        biases.append(np.mean(said))
        spreads.append(np.std(said))
    assert np.std(biases) == pytest.approx(0.1, rel=0.3)
    assert np.mean(spreads) == pytest.approx(0.02, rel=0.15)
