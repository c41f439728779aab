"""The laser scanner, in MuJoCo and as a mock, and motors that answer late."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog, load_robot
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.devices.mujoco import MujocoWorld, RobotInstance, compose_world
from rocs_bt.devices.simulated.flat import FlatRobot, FlatWorld
from tests.made_devices import make_device, sensor_mount

ROBOT = load_robot(Catalog().find("robot", "jackal").path)
GIVEN = {"site": "lidar", "rays": 181, "span": math.radians(270.0), "range": [0.06, 10.0]}
BEARINGS = np.linspace(-math.radians(135.0), math.radians(135.0), 181)
MOUNT = Pose2(0.12, 0.0, 0.0)
EMPTY = """<mujoco><worldbody><geom name="floor" type="plane" size="20 20 0.1"/>{}</worldbody></mujoco>"""


def make(tmp_path: Path, geoms: str = "", step: float = 0.005) -> MujocoWorld:
    arena = tmp_path / "arena.xml"
    arena.write_text(EMPTY.format(geoms))
    assert ROBOT.model is not None
    return compose_world(arena, [RobotInstance("R", ROBOT.model, [sensor_mount("lidar", "lidar", GIVEN)])], step=step)


def test_the_robots_file_says_the_same_of_its_mount_as_its_model(tmp_path: Path) -> None:
    (lidar,) = (sensor for sensor in ROBOT.sensors if sensor.driver == "lidar")
    fan = make_device(make(tmp_path), "R", "lidar", "lidar", lidar.arguments).fan()
    axis = fan.yaw + 0.5 * (fan.rays - 1) * fan.step
    assert lidar.mount == pytest.approx((fan.x, fan.y, axis))


def test_it_says_how_its_rays_are_mounted(tmp_path: Path) -> None:
    fan = make_device(make(tmp_path), "R", "lidar", "lidar", GIVEN).fan()
    assert (fan.x, fan.y, fan.rays, fan.reach) == pytest.approx((0.12, 0.0, 181, 10.0))
    assert [fan.yaw + k * fan.step for k in range(fan.rays)] == pytest.approx(BEARINGS.tolist())


@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    pose=st.builds(Pose2, st.floats(-0.7, 0.7), st.floats(-0.7, 0.7), st.floats(-3.1, 3.1)),
    posts=st.lists(st.tuples(st.floats(1.6, 12.0), st.floats(-3.1, 3.1), st.floats(0.05, 0.4)), max_size=6),
)
def test_agrees_with_plane_geometry(tmp_path: Path, pose: Pose2, posts: list[tuple[float, float, float]]) -> None:
    circles = [((d * math.cos(a), d * math.sin(a)), r) for d, a, r in posts]
    geoms = "".join(f'<geom type="cylinder" size="{r} .5" pos="{x} {y} .5"/>' for (x, y), r in circles)
    world = make(tmp_path, geoms)
    world.place("R", pose)
    found = np.array(make_device(world, "R", "lidar", "lidar", GIVEN).read().values)
    drive = make_locomotion("skid", effective_wheel_separation=0.55, max_wheel_speed=2.0, max_wheel_acceleration=2.5)
    mock = FlatRobot(FlatWorld(SimulatedClock(0.1), circles=circles), drive, pose, {"lidar": MOUNT})
    wanted = np.array(make_device(mock.world, mock.name, "lidar", "lidar", GIVEN).read().values)
    for ray in np.flatnonzero(
        ~np.isclose(found, wanted, rtol=0.0, atol=1e-6)
    ):  # where they differ, the ray touches a post's edge or its end
        begin = pose.compose(MOUNT)
        angle = begin.yaw + BEARINGS[ray]
        offs = [
            abs(abs((x - begin.x) * math.sin(angle) - (y - begin.y) * math.cos(angle)) - r) for (x, y), r in circles
        ]
        assert min(offs) < 1e-4 or min(abs(found[ray] - 10.0), abs(wanted[ray] - 10.0)) < 1e-6


def test_no_echo_is_infinite_and_what_is_too_near_is_the_least_range(tmp_path: Path) -> None:
    near = '<geom type="cylinder" size=".05 .05" pos="{} 0 .32"/>'
    world = make(tmp_path, near.format(0.12 + 0.07))
    world.place("R", Pose2(0.0, 0.0))
    values = make_device(world, "R", "lidar", "lidar", GIVEN).read().values
    assert values[90] == 0.06
    assert values[0] == math.inf
    world = make(tmp_path, '<geom type="box" size=".1 9 .5" pos="10.3 0 .5"/>')
    world.place("R", Pose2(0.0, 0.0))
    assert make_device(world, "R", "lidar", "lidar", GIVEN).read().values[90] == math.inf  # 10.08 m


def test_its_noise_is_its_own_and_one_instant_says_one_thing(tmp_path: Path) -> None:
    world = make(tmp_path, '<geom type="box" size=".1 9 .5" pos="3 0 .5"/>')
    world.place("R", Pose2(0.0, 0.0))
    made = [
        make_device(world, "R", "lidar", "lidar", GIVEN, noise=0.02, rng=np.random.default_rng(seed))
        for seed in (1, 1, 2)
    ]
    first, same, other = ([*sensor.read().values] for sensor in made)
    assert first == same != other
    assert [*made[0].read().values] == first
    clean = np.array(make_device(world, "R", "lidar", "lidar", GIVEN).read().values)
    seen = np.isfinite(clean)
    assert np.std(np.array(first)[seen] - clean[seen]) == pytest.approx(0.02, rel=0.3)
    assert np.isinf(np.array(first)[~seen]).all()
    world.advance(1)
    assert [*made[0].read().values] != first


WHEELS = {
    "motors": ["front_left_motor", "front_right_motor", "rear_left_motor", "rear_right_motor"],
    "wheel_radius": 0.098,
}


def driven(tmp_path: Path, delay: float, steps: int, step: float = 0.005) -> list[float]:
    """How far the robot has come after each physics step, when it is told to drive at once and to stop at 0.25 s."""
    world = make(tmp_path, step=step)
    world.place("R", Pose2(0.0, 0.0))
    wheels = make_device(world, "R", "wheels", "velocity", {**WHEELS, "max_acceleration": 5.0, "delay": delay})
    wheels.command([0.5] * 4)
    way = []
    for i in range(steps):
        if i == 50:
            wheels.neutral()
        world.advance(1)
        way.append(world.pose("R").x)
    return way


def test_motors_with_a_delay_do_the_same_later(tmp_path: Path) -> None:
    prompt, late = driven(tmp_path, 0.0, 150), driven(tmp_path, 0.1, 170)
    assert max(map(abs, late[:20])) < 1e-4
    assert late[20:] == pytest.approx(prompt, abs=2e-3)
    assert late == driven(tmp_path, 0.1, 170)
    assert late[-1] > 0.1


def test_who_has_a_command_coming_is_commanded(tmp_path: Path) -> None:
    world = make(tmp_path)
    world.place("R", Pose2(0.0, 0.0))
    wheels = make_device(world, "R", "wheels", "velocity", {**WHEELS, "delay": 0.1})
    assert not world.commanded("R")
    wheels.command([0.5] * 4)
    assert world.commanded("R")
    wheels.neutral()
    world.advance(200)
    assert not world.commanded("R")


def test_a_delay_is_a_whole_number_of_steps(tmp_path: Path) -> None:
    with pytest.raises(
        InputError, match=r"the delay of R's motors, 7 ms, is not a whole number of physics steps of 5 ms"
    ):
        make_device(make(tmp_path), "R", "wheels", "velocity", {**WHEELS, "delay": 0.007})
