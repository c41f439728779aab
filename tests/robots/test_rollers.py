"""Robots on wheels with real rollers move in every direction as their kinematics say."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from rocs_bt.base.geometry import Pose2, Twist2, wrap_angle
from rocs_bt.catalog import Catalog, RobotSpec
from rocs_bt.devices.mujoco import MujocoWorld, RobotInstance, compose_world
from tests.made_devices import make_device

ROBOTS = ["robotino", "rosbot_xl"]
TWISTS = [
    Twist2(0.5), Twist2(-0.5), Twist2(0.0, left=0.5), Twist2(0.0, left=-0.5), Twist2(0.35, left=0.35),
    Twist2(-0.2, left=0.3), Twist2(0.0, turn=1.0), Twist2(0.3, turn=0.6), Twist2(0.3, turn=-1.0, left=0.25),
]  # fmt: skip  # twists, several on a line
MakeWorld = Callable[..., MujocoWorld]


@pytest.fixture
def spec(request: pytest.FixtureRequest) -> RobotSpec:
    return Catalog().load_robot(request.param)


@pytest.fixture
def make_world(tmp_path: Path) -> MakeWorld:
    def make(spec: RobotSpec, geoms: str = "", names: tuple[str, ...] = ("R",)) -> MujocoWorld:
        arena = tmp_path / "arena.xml"
        arena.write_text(
            f'<mujoco><worldbody><geom name="floor" type="plane" size="0 0 1"/>{geoms}</worldbody></mujoco>'
        )
        assert spec.model is not None
        return compose_world(arena, [RobotInstance(name, spec.model) for name in names])

    return make


def drive_for(world: MujocoWorld, spec: RobotSpec, twist: Twist2, seconds: float, name: str = "R") -> None:
    """Command the wheel speeds of a twist and let the world run."""
    wheels = make_device(world, name, "wheels", "velocity", spec.actuators[0].arguments)
    wheels.command(spec.locomotion.command(twist).tolist())
    world.advance(round(seconds / 0.005))


def mean_twist(world: MujocoWorld, seconds: float) -> Twist2:
    """Mean body twist while the world runs on."""
    steps, moved, turned = round(seconds / 0.005), np.zeros(2), 0.0
    for _ in range(steps):
        before = world.pose("R")
        world.advance(1)
        after = world.pose("R")
        yaw = before.yaw + 0.5 * wrap_angle(after.yaw - before.yaw)
        dx, dy = after.x - before.x, after.y - before.y
        moved += (math.cos(yaw) * dx + math.sin(yaw) * dy, math.cos(yaw) * dy - math.sin(yaw) * dx)
        turned += wrap_angle(after.yaw - before.yaw)
    forward, left = (moved / seconds).tolist()
    return Twist2(forward, turned / seconds, left)


@pytest.mark.parametrize("spec", ROBOTS, indirect=True)
@pytest.mark.parametrize("twist", TWISTS, ids=str)
def test_it_moves_as_its_kinematics_say_within_a_few_per_cent(
    make_world: MakeWorld, spec: RobotSpec, twist: Twist2
) -> None:
    world = make_world(spec)
    drive_for(world, spec, twist, 1.0)
    found = mean_twist(world, 2.0)
    speed = math.hypot(twist.forward, twist.left)
    # Sideways, rollers at an angle to the floor push a little less; on a curve, soft contacts creep outward.
    assert math.hypot(found.forward - twist.forward, found.left - twist.left) < 0.05 * speed + 0.002
    assert abs(found.turn - twist.turn) < 0.02 * abs(twist.turn) + 0.01
    assert not world.contacts()


def test_only_a_robot_that_declares_it_gets_the_sparse_solver(make_world: MakeWorld) -> None:
    import mujoco

    sparse, auto = int(mujoco.mjtJacobian.mjJAC_SPARSE), int(mujoco.mjtJacobian.mjJAC_AUTO)
    found = {name: make_world(Catalog().load_robot(name)).model.opt.jacobian for name in ("pioneer_p3dx", *ROBOTS)}
    assert found == {"pioneer_p3dx": auto, "robotino": auto, "rosbot_xl": sparse}


@pytest.mark.parametrize("spec", ROBOTS, indirect=True)
def test_it_stands_still_on_its_rollers(make_world: MakeWorld, spec: RobotSpec) -> None:
    world = make_world(spec)
    world.advance(200)
    touching = {world.model.geom(g).name for pair in world.data.contact.geom.tolist() for g in pair}
    assert all(name == "floor" or "roller" in name for name in touching)
    start = world.pose("R")
    world.advance(400)
    assert start.distance(world.pose("R")) < 0.001
    assert abs(wrap_angle(world.pose("R").yaw - start.yaw)) < 0.001


@pytest.mark.parametrize("spec", ROBOTS, indirect=True)
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_wall_beside_it_is_touched_by_its_hull(make_world: MakeWorld, spec: RobotSpec, side: float) -> None:
    world = make_world(spec, f'<geom name="wall" type="box" size="2 0.05 0.5" pos="0 {side * 0.4} 0.5"/>')
    drive_for(world, spec, Twist2(0.0, left=0.3 * side), 1.0)
    assert {contact.other for contact in world.contacts()} == {"wall"}


@pytest.mark.parametrize("spec", ROBOTS, indirect=True)
def test_two_of_a_kind_touch_each_other(make_world: MakeWorld, spec: RobotSpec) -> None:
    world = make_world(spec, names=("R", "Q"))
    world.place("R", Pose2(0.0, 0.0))
    world.place("Q", Pose2(0.0, 0.6))
    drive_for(world, spec, Twist2(0.0, left=0.3), 1.5)
    assert {contact.robot for contact in world.contacts()} == {"R", "Q"}
    assert world.pose("Q").y > 0.62
