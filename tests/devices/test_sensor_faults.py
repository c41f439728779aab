"""Faults of simulated sensors and wheels: latency, losses, missing echoes, sweeps, errors of poses, slip."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog, load_robot
from rocs_bt.devices.mujoco import MujocoWorld, RobotInstance, compose_world
from tests.made_devices import make_device, sensor_mount

ROBOT = load_robot(Catalog().find("robot", "jackal").path)
MOTORS = ["front_left_motor", "front_right_motor", "rear_left_motor", "rear_right_motor"]
WHEELS = {"motors": MOTORS, "wheel_radius": 0.098}
LIDAR = {"site": "lidar", "rays": 181, "span": math.radians(270.0), "range": [0.06, 10.0]}
CONES = {"sites": ["lidar"], "range": [0.05, 5.0]}
WORLD = """<mujoco><worldbody><geom name="floor" type="plane" size="20 20 0.1"/>
<geom type="cylinder" size="0.3 0.5" pos="3 0 0.5"/><geom name="roof" type="box" size="9 9 0.1" pos="0 0 2"/>
<body name="person" mocap="true" pos="0 -2 0.5"><geom type="cylinder" size="0.2 0.5"/></body></worldbody></mujoco>"""


@pytest.fixture
def world(tmp_path: Path) -> MujocoWorld:
    arena = tmp_path / "arena.xml"
    arena.write_text(WORLD)
    assert ROBOT.model is not None
    mounts = [sensor_mount("lidar", "lidar", LIDAR), sensor_mount("cones", "range_cone", CONES)]
    return compose_world(arena, [RobotInstance("R", ROBOT.model, mounts)], step=0.005, clock=SimulatedClock(0.005))


def rng(seed: int = 3) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(seed))


def readings(world: MujocoWorld, sensors: list[Any], count: int, steps: int = 10) -> list[list[Any]]:
    """Readings of some sensors, and the time after them, in each of some periods."""
    found = []
    for _ in range(count):
        found.append([*(sensor.read() for sensor in sensors), world.stamp])
        world.advance(steps)
    return found


DRIVERS: dict[str, dict[str, Any]] = {
    "position": {},
    "orientation": {},
    "twist": {"speed_noise": 0.01},
    "gyro": {},
    "lidar": LIDAR,
    "range_cone": CONES,
    "wheel_speed": WHEELS,
    "wheel_travel": {**WHEELS, "counts": 1000},
}


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize("latency", [0.005, 0.05, 0.12])
def test_a_late_reading_has_the_values_and_the_stamp_of_its_measurement(world, driver, latency):
    name = {"range_cone": "cones"}.get(driver, "device")
    ideal, late = (
        make_device(world, "R", name, driver, DRIVERS[driver], noise=noise, rng=rng(), latency=each)
        for each in (0.0, latency)
        for noise in [0.0 if driver == "twist" else 0.01]
    )
    world.drive(world.motors("R", MOTORS), [3.0, 4.0, 3.0, 4.0])
    pairs = readings(world, [ideal, late], 12)
    measured = {reading.stamp: reading for reading, _, _ in pairs}
    for _, reading, t in pairs:
        stamp = max((s for s in measured if s + latency <= t + 1e-9), default=0.0)
        assert reading.stamp == stamp
        assert reading == measured[stamp]


def test_a_reading_is_lost_with_the_given_probability_and_the_others_are_equal(world):
    made = [make_device(world, "R", "p", "position", {}, noise=0.1, rng=rng(), drop_out=p) for p in (0.0, 0.3, 1.0)]
    found = readings(world, made, 2000, steps=1)
    whole = {reading.stamp: reading for reading, *_ in found}
    got = [reading.stamp for _, reading, _, _ in found]
    assert all(reading == whole[reading.stamp] for _, reading, _, _ in found)
    lost = 2000 - len(set(got))
    assert abs(lost - 600) < 4.0 * math.sqrt(2000 * 0.3 * 0.7)
    assert got == sorted(got)
    assert {reading.stamp for *_, reading, _ in found} == {0.0}  # only the first one arrived


@pytest.mark.parametrize(("name", "driver"), [("lidar", "lidar"), ("cones", "range_cone")])
def test_an_echo_is_missing_with_the_given_probability_and_the_others_are_equal(world, name, driver):
    given, share = DRIVERS[driver], 0.2
    whole, patchy = (
        make_device(world, "R", name, driver, {**given, **more}, noise=0.01, rng=rng())
        for more in ({}, {"missing_echo": share})
    )
    found = readings(world, [whole, patchy], 300, steps=1)
    values = np.array([[all_.values, some.values] for all_, some, _ in found])
    echo = np.isfinite(values[:, 0])
    missing = echo & ~np.isfinite(values[:, 1])
    assert np.array_equal(values[:, 0][echo & ~missing], values[:, 1][echo & ~missing])
    assert abs(missing.sum() - share * echo.sum()) < 4.0 * math.sqrt(echo.sum() * share * (1.0 - share))
    assert patchy.read() == patchy.read()


def test_each_ray_of_a_sweep_sees_the_world_of_its_own_time(world):
    sweep, steps = 0.1, 20
    world.set_object_velocity("person", (0.0, 2.0))
    swept = make_device(world, "R", "lidar", "lidar", {**LIDAR, "sweep": sweep}, rng=rng())
    still = make_device(world, "R", "lidar", "lidar", LIDAR, rng=rng())
    assert swept.read() == still.read()  # before the start nothing has moved
    world.drive(world.motors("R", MOTORS), [-8.0, 8.0, -8.0, 8.0])
    seen = {}
    for step in range(120):
        seen[step] = np.array(still.read().values)
        world.advance(1)
    seen[120] = np.array(still.read().values)
    reading = swept.read()
    of_ray = 120 - steps + np.rint(np.linspace(0.0, steps, 181)).astype(int)
    expected = np.array([seen[step][ray] for ray, step in enumerate(of_ray)])
    assert reading.stamp == pytest.approx(world.stamp - sweep)
    assert np.array_equal(reading.values, expected)
    assert not np.array_equal(reading.values, seen[120])


@pytest.mark.parametrize(("driver", "unit"), [("position", 2), ("orientation", 1)])
def test_the_error_of_a_pose_drifts_as_a_random_walk_and_jumps_at_random_times(world, driver, unit):
    drifting = [make_device(world, "R", "p", driver, {"drift": 0.1}, rng=rng(seed)) for seed in range(300)]
    jumping = [
        make_device(world, "R", "p", driver, {"jump": 0.5, "jump_every": 1.0}, rng=rng(seed)) for seed in range(300)
    ]
    truth = make_device(world, "R", "p", driver, {})

    def errors(sensors: list[Any]) -> Any:
        exact = np.array(truth.read().values)
        return np.array([np.array(sensor.read().values) - exact for sensor in sensors])[:, :unit]

    assert not errors(drifting).any()
    assert not errors(jumping).any()
    changes = 0
    for _ in range(20):
        before = errors(jumping)[:, 0]
        errors(drifting)
        world.advance(20)
        changes += int(np.count_nonzero(np.abs(errors(jumping)[:, 0] - before) > 1e-6))
    assert errors(drifting).std() == pytest.approx(0.1 * math.sqrt(2.0), rel=0.15)
    assert errors(jumping).std() == pytest.approx(0.5 * math.sqrt(1.0 - math.exp(-2.0)), rel=0.15)
    assert abs(changes - 6000 * -math.expm1(-0.1)) < 4.0 * math.sqrt(6000 * 0.09)


def test_wheels_that_slip_lose_that_share_of_the_travel_and_encoders_do_not_see_it(world):
    found = {}
    for slip in ([], [0.2], [0.2, 0.0, 0.2, 0.0]):
        world.place("R", Pose2(-6.0, 3.0))
        actuator = make_device(world, "R", "wheels", "velocity", {**WHEELS, "slip": slip})
        encoders = make_device(world, "R", "travel", "wheel_travel", {**WHEELS, "counts": 100000})
        start, before = world.pose("R"), encoders.read().values
        actuator.command([0.5] * 4)
        world.advance(200)
        assert actuator.measured() == pytest.approx([0.5] * 4, abs=0.02)
        travel = np.subtract(encoders.read().values, before)
        found[len(slip)] = start.distance(world.pose("R")), float(travel.mean()), world.pose("R").yaw
        actuator.neutral()
        world.advance(100)
        world._grip.clear()
    assert found[1][0] == pytest.approx(0.8 * found[0][0], rel=0.02)
    assert found[1][1] == pytest.approx(found[0][1], rel=0.02)
    assert found[4][2] > 0.1 > abs(found[0][2])  # the left wheels lose, so the robot curves to the left


def test_shares_of_slip_are_one_for_each_wheel(world):
    with pytest.raises(InputError, match="one share for all wheels or one for each of 4"):
        make_device(world, "R", "wheels", "velocity", {**WHEELS, "slip": [0.1, 0.2]})
