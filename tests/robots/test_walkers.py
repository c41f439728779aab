"""What holds for every robot that walks: motion as commanded, stops, pushes, contacts between two of a kind."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from rocs_bt.base.geometry import Pose2, Twist2
from rocs_bt.devices.mujoco import RobotInstance, compose_world
from tests.robots.walker import CATALOG, STEP, Walker


@dataclass(frozen=True)
class Row:
    """Bounds of a robot: times in s, shares of the command, tilts in degrees, lengths in m, forces in N."""

    begin: float  # until the gait is steady
    measured: float  # whole cycles of the gait
    twists: tuple[Twist2, ...]
    share: float  # error of the speed
    tilt: float
    fastest: tuple[Twist2, ...]
    sway: float  # of the body over the feet
    walking: float
    forces: tuple[float, float]
    tilt_pushed: float
    near: float  # distance of two robots that touch


ROWS = {
    "quadruped": Row(
        1.6, 2.0,
        (Twist2(0.5), Twist2(-0.3), Twist2(0.0, left=0.3), Twist2(0.0, left=-0.2), Twist2(0.0, turn=1.0),
         Twist2(0.0, turn=-1.5), Twist2(0.4, turn=0.6), Twist2(0.3, left=0.15, turn=-0.4)),
        0.05, 8.0, (Twist2(0.6), Twist2(0.0, left=-0.3), Twist2(0.0, turn=1.5)), 0.02, 0.4, (60.0, 100.0), 12.0, 0.3,
    ),
    "humanoid": Row(
        5.0, 3.0,
        (Twist2(0.1), Twist2(0.25), Twist2(-0.15), Twist2(0.0, left=0.08), Twist2(0.0, left=-0.08),
         Twist2(0.0, turn=0.4), Twist2(0.0, turn=-0.8), Twist2(0.2, turn=0.4), Twist2(0.1, left=0.05, turn=-0.3)),
        0.08, 5.0, (Twist2(0.25), Twist2(0.0, left=-0.08), Twist2(0.0, turn=0.8)), 0.04, 0.15, (30.0, 60.0), 10.0, 0.1,
    ),
}  # fmt: skip  # twists, several on a line
MakeWalker = Callable[[str], Walker]


@pytest.fixture
def walker(tmp_path: Path) -> MakeWalker:
    return lambda name: Walker(name, tmp_path)


def test_every_robot_that_walks_has_a_row() -> None:
    robots = [CATALOG.load_robot(entry.name) for entry in CATALOG.list("robot")]
    assert {robot.name for robot in robots if robot.locomotion.kind == "legged" and not robot.bases} == {*ROWS}


@pytest.mark.parametrize(("name", "twist"), [(n, t) for n, row in ROWS.items() for t in row.twists], ids=str)
def test_it_walks_as_commanded_within_a_few_per_cent(walker: MakeWalker, name: str, twist: Twist2) -> None:
    robot, row = walker(name), ROWS[name]
    robot.go(twist, row.begin)
    found = robot.mean_twist(row.measured)
    speed = math.hypot(twist.forward, twist.left)
    assert math.hypot(found.forward - twist.forward, found.left - twist.left) < row.share * speed + 0.01
    assert abs(found.turn - twist.turn) < 0.05 * abs(twist.turn) + 0.03
    assert robot.tilt < math.radians(row.tilt)
    assert robot.upright


@pytest.mark.parametrize(("name", "twist"), [(n, t) for n, row in ROWS.items() for t in row.fastest], ids=str)
def test_neutral_at_full_speed_leaves_it_standing_within_its_stop_distance(
    walker: MakeWalker, name: str, twist: Twist2
) -> None:
    robot, row = walker(name), ROWS[name]
    robot.go(twist, row.begin)
    before = robot.world.pose("R")
    robot.gait.neutral()
    robot.wait(2.0)
    stopped = robot.world.pose("R")
    assert before.distance(stopped) <= robot.locomotion.stop_distance(twist) + row.sway
    robot.wait(1.0)
    assert robot.world.pose("R").distance(stopped) < 0.005, "it does not step any more"
    assert robot.upright


@pytest.mark.parametrize("moving", [False, True])
@pytest.mark.parametrize(("name", "force"), [(n, f) for n, row in ROWS.items() for f in row.forces])
@pytest.mark.parametrize("direction", range(0, 360, 90))
def test_a_push_does_not_throw_it_over(
    walker: MakeWalker, name: str, moving: bool, force: float, direction: int
) -> None:
    robot, row = walker(name), ROWS[name]
    walking = Twist2(row.walking if moving else 0.0)
    robot.go(walking, 1.5)
    robot.push(force, math.radians(direction))
    robot.go(walking, 1.5)
    assert robot.tilt < math.radians(row.tilt_pushed)
    robot.go(Twist2(0.0), 2.0)
    assert robot.upright


@pytest.mark.parametrize("name", ROWS)
def test_two_touch_each_other_but_not_themselves(tmp_path: Path, name: str) -> None:
    arena = tmp_path / "arena.xml"
    arena.write_text('<mujoco><worldbody><geom name="floor" type="plane" size="0 0 1"/></worldbody></mujoco>')
    model = CATALOG.load_robot(name).model
    assert model is not None
    world = compose_world(arena, [RobotInstance(each, model) for each in ("R", "Q")], step=STEP)
    world.place("Q", Pose2(0.0, 2.0))
    world.advance(1)
    assert not [pair for pair in world.data.contact.geom.tolist() if world.model.geom("floor").id not in pair]
    world.place("Q", Pose2(ROWS[name].near, 0.0))
    world.advance(1)
    assert {contact.robot for contact in world.contacts()} == {"R", "Q"}
