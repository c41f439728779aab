"""Odometer instead of the true pose: dead reckoning from the wheels, or from the base of a body without them."""

from __future__ import annotations

import math

import pytest

from rocs_bt.base.geometry import Pose2, Twist2
from rocs_bt.catalog import Catalog
from rocs_bt.declare import replaced
from rocs_bt.devices.simulated import PoseSensor
from rocs_bt.event import NullSink
from rocs_bt.simulation import build_world

WORLD = '<mujoco><worldbody><geom name="floor" type="plane" size="20 20 0.1"/></worldbody></mujoco>'
SCENARIO = """format = "scenario/2"
doc = "A robot alone."
world = "floor"
duration = "10 s"
[[agent]]
name = "R"
robot = "{}"
mission = "navigate"
parameters = {{ goal = "goal" }}
x = "1 m"
y = "2 m"
yaw = "90 deg"
[[place]]
name = "goal"
x = "3 m"
y = "3 m"
"""


@pytest.fixture
def odometry(tmp_path):
    """Poses by odometry and in truth after a drive of 4 s with a twist, and the length of the way."""
    (tmp_path / "scenarios/worlds").mkdir(parents=True)
    (tmp_path / "scenarios/worlds/floor.xml").write_text(WORLD)

    def drive(robot, twist, share=1e-9, seed=1, friction=None):
        (tmp_path / "scenarios/alone.toml").write_text(SCENARIO.format(robot))
        catalog = Catalog(tmp_path)
        scenario, known = catalog.load_scenario("alone"), catalog.load_perturbations()
        changes = [known["odometry"].at(share)]
        changes += [known["friction"].at(friction)] if friction else []
        cold = replaced(scenario, agents=(replaced(scenario.agents[0], perturbations=tuple(changes)),))
        world = build_world(cold, catalog, seed, NullSink())
        robot_spec = world.robots["R"]
        command = robot_spec.locomotion.command(twist).tolist()
        sensors = [each for each in world.sensors["R"].values() if isinstance(each, PoseSensor)]
        way, last = 0.0, world.world.pose("R")
        for _ in range(80):
            values = [value for each in sensors for value in each.sample()]
            world.actuators["R"][robot_spec.motion.actuator].command(command)
            world.world.advance(10)
            way, last = way + last.distance(world.world.pose("R")), world.world.pose("R")
        values = [value for each in sensors for value in each.sample()]
        assert not any(each.exact for each in sensors)
        return Pose2(values[0], values[1], values[3]), last, way

    return drive


@pytest.mark.parametrize(
    ("robot", "twist"),
    [
        ("pioneer_p3dx", Twist2(0.3, 0.3)),
        ("jackal", Twist2(0.5, 0.0)),
        ("rosbot_xl", Twist2(0.3, 0.2, 0.2)),
        ("quadruped", Twist2(0.3, 0.2)),
    ],
)
def test_without_errors_and_slip_it_is_the_true_pose(odometry, robot, twist) -> None:
    found, true, way = odometry(robot, twist)
    assert way > 0.8
    assert found.distance(true) < 0.04 * way
    assert abs(math.remainder(found.yaw - true.yaw, math.tau)) < 1e-6


def test_wheels_that_slip_travel_farther_than_the_robot(odometry) -> None:
    found, true, way = odometry("jackal", Twist2(1.5, 0.0), friction=0.05)
    assert found.distance(true) > 0.2
    assert found.distance(Pose2(1.0, 2.0)) > way + 0.2


@pytest.mark.parametrize("robot", ["pioneer_p3dx", "quadruped"])
def test_the_errors_are_a_share_of_the_way_and_a_random_walk_of_the_yaw(odometry, robot) -> None:
    exact = odometry(robot, Twist2(0.3, 0.0))
    off = [odometry(robot, Twist2(0.3, 0.0), share=0.05, seed=seed) for seed in range(1, 7)]
    ways = [found.distance(Pose2(1.0, 2.0)) / exact[0].distance(Pose2(1.0, 2.0)) - 1.0 for found, _, _ in off]
    yaws = [math.remainder(found.yaw - true.yaw, math.tau) for found, true, _ in off]
    assert 0.015 < math.sqrt(sum(error**2 for error in ways) / 6) < 0.1  # 0.05 is expected
    assert 0.03 < math.sqrt(sum(error**2 for error in yaws) / 6) < 0.2  # 0.05 * sqrt(4 s) is expected
