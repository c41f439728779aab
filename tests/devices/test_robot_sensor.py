"""The robot sensor, in MuJoCo and as a mock: who is in view, where, and behind what."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import RobotSpec
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.devices.mujoco import MujocoWorld
from rocs_bt.devices.simulated.flat import FlatRobot, FlatWorld
from tests.made_devices import make_device

MakeWorld = Callable[..., MujocoWorld]
NOBODY = [0.0, math.inf, 0.0]
DRIVE = make_locomotion("differential", wheel_separation=0.331, max_wheel_speed=1.2, max_wheel_acceleration=1.5)


@pytest.fixture
def world(make_world: MakeWorld) -> MujocoWorld:
    """R2 at the origin (tag 1), R1 and R3 (tags 2 and 3) far away."""
    made = make_world(others=("R1", "R3"))
    made.place("R1", Pose2(50.0, 50.0))
    made.place("R3", Pose2(-50.0, 50.0))
    made.place("R2", Pose2(0.0, 0.0, math.radians(30.0)))
    return made


def read(world: MujocoWorld, **parameters: float) -> list[list[float]]:
    sensor = make_device(world, "R2", "eye", "robot_sensor", {"max_range": 5.0, "max_peers": 2, **parameters})
    values = list(sensor.read().values)
    return [values[i : i + 3] for i in range(0, len(values), 3)]


def test_tells_tag_range_and_bearing_of_each_the_nearest_first(world: MujocoWorld) -> None:
    world.place("R1", Pose2(0.0, 2.0))
    world.place("R3", Pose2(1.0, -1.0, 1.0))
    assert read(world) == [
        [3.0, pytest.approx(math.sqrt(2.0)), pytest.approx(math.radians(-75.0))],
        [2.0, pytest.approx(2.0), pytest.approx(math.radians(60.0))],
    ]
    assert [slot[0] for slot in read(world, max_peers=1)] == [3.0]


def test_an_empty_slot_is_valid_and_says_nobody(world: MujocoWorld) -> None:
    assert read(world) == [NOBODY, NOBODY]


@pytest.mark.parametrize(
    ("pose", "seen"),
    [
        (Pose2(4.9, 0.0), True),
        (Pose2(5.1, 0.0), False),
        (Pose2(-2.0, 0.0), False),
        (Pose2(1.0, 1.0), True),
    ],
)
def test_sees_to_its_reach_within_its_field_of_view(world: MujocoWorld, pose: Pose2, seen: bool) -> None:
    world.place("R1", pose)
    assert (read(world, half_angle=math.radians(45.0))[0] != NOBODY) is seen


BOX = '<geom name="box" type="box" size="0.1 0.1 {half}" pos="1 0 {half}"/>'


@pytest.mark.parametrize(("half", "seen"), [(0.25, False), (0.05, True)])
def test_a_box_hides_unless_it_is_lower_than_the_line_of_sight(make_world: MakeWorld, half: float, seen: bool) -> None:
    world = make_world(BOX.format(half=half), others=("R1",))
    world.place("R1", Pose2(2.0, 0.0))
    assert (read(world)[0] != NOBODY) is seen
    world.place("R1", Pose2(2.0, 2.0))
    assert read(world)[0] != NOBODY


def test_another_robot_hides_and_what_is_only_drawn_does_not(make_world: MakeWorld) -> None:
    veil = '<geom name="veil" type="box" size="0.01 1 1" pos="0.7 0 1" contype="0" conaffinity="0"/>'
    world = make_world(veil, others=("R1", "R3"))
    world.place("R1", Pose2(1.5, 0.0))
    world.place("R3", Pose2(3.0, 0.0))
    assert [slot[0] for slot in read(world)] == [2.0, 0.0]


def test_noise_is_as_told_and_the_same_within_one_instant(world: MujocoWorld) -> None:
    world.place("R1", Pose2(0.0, 2.0))
    given = {"max_range": 5.0, "max_peers": 1, "range_noise": 0.05, "bearing_noise": 0.02}
    sensor = make_device(world, "R2", "eye", "robot_sensor", given, rng=np.random.default_rng(1))
    found = []
    for _ in range(400):
        assert sensor.read().values == sensor.read().values
        found.append(sensor.read().values[1:])
        world.stamp += 0.05
    away = np.array(found) - [2.0, math.radians(60.0)]
    assert np.abs(away.mean(axis=0)) == pytest.approx([0.0, 0.0], abs=0.01)
    assert away.std(axis=0) == pytest.approx([0.05, 0.02], rel=0.1)


def test_who_else_is_in_view_changes_nothing_in_what_is_said_of_one(world: MujocoWorld) -> None:
    given = {"max_range": 5.0, "range_noise": 0.05}
    world.place("R1", Pose2(0.0, 2.0))
    alone = make_device(world, "R2", "eye", "robot_sensor", given, rng=np.random.default_rng(1)).read().values[:3]
    world.place("R3", Pose2(0.0, -3.0))
    assert (
        make_device(world, "R2", "eye", "robot_sensor", given, rng=np.random.default_rng(1)).read().values[:3] == alone
    )


def test_one_noise_for_tag_range_and_bearing_is_refused(world: MujocoWorld) -> None:
    with pytest.raises(InputError, match="range_noise and bearing_noise"):
        make_device(world, "R2", "eye", "robot_sensor", {"max_range": 5.0}, noise=0.1)


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(x=st.floats(-3.0, 3.0), y=st.floats(-3.0, 3.0), yaw=st.floats(-3.1, 3.1))
def test_the_mock_sees_what_mujoco_sees(wall: MujocoWorld, x: float, y: float, yaw: float) -> None:
    assume(math.hypot(x, y) > 0.6)
    wall.place("R2", Pose2(0.0, 0.0, yaw))
    wall.place("R1", Pose2(x, y))
    # Near the edge of the wall the two may differ by its thickness; a hull that reaches through it is seen.
    assume(abs(abs(y / x) - 1.0) > 0.1 if abs(x) > 1e-3 else True)
    assume(abs(x - 1.0) > 0.3)
    mock = FlatWorld(SimulatedClock(0.05), segments=[((1.0, -1.0), (1.0, 1.0))])
    robot = FlatRobot(mock, DRIVE, Pose2(0.0, 0.0, yaw))
    FlatRobot(mock, DRIVE, Pose2(x, y))
    given = {"max_range": 5.0, "max_peers": 1, "half_angle": 2.0}
    seen = make_device(robot.world, robot.name, "eye", "robot_sensor", given).read().values
    assert list(make_device(wall, "R2", "eye", "robot_sensor", given).read().values) == pytest.approx(list(seen))


@pytest.fixture
def wall(make_world: MakeWorld, p3dx: RobotSpec) -> MujocoWorld:
    """A wall at x = 1 m, from y = -1 m to 1 m."""
    return make_world('<geom name="wall" type="box" size="0.001 1 0.25" pos="1 0 0.25"/>', others=("R1",))
