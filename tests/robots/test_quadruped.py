"""The quadruped keeps still, walks as commanded, and stays on its feet when it is pushed or crosses a step."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import pytest

from rocs_bt.base.geometry import Twist2, wrap_angle
from rocs_bt.simulation.fall import FallWatch
from tests.robots.walker import Walker

MakeWalker = Callable[..., Walker]


@pytest.fixture
def walker(tmp_path: Path) -> MakeWalker:
    return lambda geoms="": Walker("quadruped", tmp_path, geoms)


def test_it_stands_still_without_stepping(walker: MakeWalker) -> None:
    robot = walker()
    robot.wait(0.5)
    start, height = robot.world.pose("R"), []
    for _ in range(100):
        robot.wait(0.1)
        height.append(robot.world.pose3("R").z)
    end = robot.world.pose("R")
    assert start.distance(end) < 0.002
    assert abs(wrap_angle(end.yaw - start.yaw)) < math.radians(0.2)
    assert max(height) - min(height) < 0.002
    assert robot.tilt < math.radians(2.0)


@pytest.mark.parametrize("speed", [0.3, 0.5])
def test_it_crosses_a_step_of_four_centimetres(walker: MakeWalker, speed: float) -> None:
    robot = walker('<geom name="floor_step" type="box" size="0.3 1 0.02" pos="0.9 0 0.02"/>')
    while robot.world.pose("R").x < 1.6:
        yaw, y = robot.world.pose("R").yaw, robot.world.pose("R").y
        robot.go(Twist2(speed, turn=-2.0 * yaw - y), 0.05)
        assert robot.world.stamp < 12.0, "it walks on"
    assert robot.tilt < math.radians(15.0)
    robot.go(Twist2(0.0), 1.0)
    assert robot.upright


@pytest.mark.parametrize("axis", [(1.0, 0.0), (0.0, 1.0)], ids=["on its back", "rolled over ahead"])
def test_it_has_fallen_when_it_is_thrown_over(walker: MakeWalker, axis: tuple[float, float]) -> None:
    robot, watch = walker(), FallWatch()
    robot.wait(0.2)
    q = robot.world.body("R").q
    robot.world.data.qpos[q + 2 : q + 7] = 0.5, 0.0, *axis, 0.0
    fallen = False
    for k in range(130):
        robot.wait(0.05)
        fallen = fallen or watch.update(0.05 * k, robot.world.tilt("R"), robot.world.ground_contact("R"))
    assert fallen


@pytest.mark.parametrize("direction", [60, 120, 250, 300])
def test_after_a_fall_the_next_command_makes_it_get_up_and_walk_on(walker: MakeWalker, direction: int) -> None:
    robot, watch = walker(), FallWatch()
    robot.go(Twist2(0.3), 1.0)
    robot.push(250.0, math.radians(direction))
    fallen = False
    for k in range(120):
        robot.go(Twist2(0.3), 0.05)
        fallen = fallen or watch.update(0.05 * k, robot.world.tilt("R"), robot.world.ground_contact("R"))
    assert robot.tilt > math.radians(90.0), "it fell"
    assert not fallen, "it is up again within 5 s"
    assert robot.upright
    assert robot.mean_twist(2.0).forward == pytest.approx(0.3, abs=0.03)


def test_it_gets_up_from_its_back_and_from_both_sides(walker: MakeWalker) -> None:
    for roll in (90.0, 180.0, 270.0):
        robot = walker()
        robot.wait(0.2)
        q, half = robot.world.body("R").q, 0.5 * math.radians(roll)
        robot.world.data.qpos[q + 2 : q + 7] = 0.4, math.cos(half), math.sin(half), 0.0, 0.0
        robot.go(Twist2(0.2), 5.0)
        assert robot.upright


def test_without_a_command_it_stays_down_with_folded_legs(walker: MakeWalker) -> None:
    robot = walker()
    robot.wait(0.2)
    robot.push(300.0, math.radians(90))
    robot.wait(2.0)
    lying = robot.world.pose("R")
    robot.wait(3.0)
    assert robot.tilt > math.radians(90.0)
    assert not robot.upright
    assert robot.world.pose("R").distance(lying) < 0.01, "it does not move"
    robot.go(Twist2(0.2), 3.0)
    assert robot.upright


def test_a_collision_is_reported_when_its_front_touches(walker: MakeWalker) -> None:
    robot = walker('<geom name="wall" type="box" size="0.05 1 0.5" pos="0.8 0 0.5"/>')
    world = robot.world
    front, wall = [world.model.geom(f"R/{part}").id for part in ("head", "front_scanner")], world.model.geom("wall").id
    robot.gait.command([0.4, 0.0, 0.0])
    touched = False
    while not (contacts := world.contacts()):
        assert not touched, "in the control period of the first touch"
        world.advance(10)
        world.update_poses()
        touched = any(mujoco.mj_geomDistance(world.model, world.data, g, wall, 1.0, None) < 0.0 for g in front)
    assert touched
    assert {contact.other for contact in contacts} == {"wall"}


@pytest.mark.parametrize("part", ["front_scanner", "rear_scanner", "front_left_hip", "rear_right_hip"])
def test_scanners_and_hips_collide(walker: MakeWalker, part: str) -> None:
    robot = walker('<body name="post" mocap="true" pos="3 0 0.5"><geom type="cylinder" size="0.02 0.5"/></body>')
    world = robot.world
    robot.wait(0.2)
    world.update_poses()
    world.data.mocap_pos[0, :2] = world.data.geom(f"R/{part}").xpos[:2]
    world.advance(1)
    touching = {world.model.geom(geom).name for pair in world.data.contact.geom.tolist() for geom in pair}
    assert f"R/{part}" in touching
