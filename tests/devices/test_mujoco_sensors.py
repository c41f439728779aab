"""Sensors in MuJoCo against what geometry says."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2, Pose3
from rocs_bt.base.units import Metres
from rocs_bt.catalog import RobotSpec, load_robot
from rocs_bt.control.locomotion_kinds import Axis, TurnAxis, make_locomotion
from rocs_bt.devices.mujoco import MujocoSensor, MujocoWorld, RobotInstance, compose_world
from rocs_bt.devices.simulated import RangeCone
from rocs_bt.devices.simulated.flat import FlatRobot, FlatWorld
from tests.made_devices import make_device, sensor_mount

from .conftest import EMPTY, ROOT

MakeWorld = Callable[..., MujocoWorld]

WALL = '<geom name="wall" type="box" size="0.05 3 0.25" pos="1.05 0 0.25"/>'  # its face stands at x = 1


def sonar_of(world: MujocoWorld, p3dx: RobotSpec, **changes: object) -> RangeCone:
    spec = next(s for s in p3dx.sensors if s.name == "sonar")
    sensor = make_device(world, "R2", "sonar", spec.driver, {**spec.arguments, **changes})
    assert isinstance(sensor, RangeCone)
    return sensor


def test_a_wall_is_as_far_as_the_nearest_ray_of_each_cone(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world(WALL)
    world.place("R2", Pose2(0.3, 0.0, 0.0))
    sonar = sonar_of(world, p3dx)
    for beam, value in zip(sonar.beams(), sonar.read().values, strict=True):
        rays = [beam.yaw + a for a in np.radians([-15.0, -7.5, 0.0, 7.5, 15.0])]
        hits = [(0.7 - beam.x) / math.cos(a) for a in rays if math.cos(a) > 1e-6]
        hits = [h for h in hits if abs(beam.y) < 3.0]
        wanted = min(hits, default=math.inf)
        assert value == pytest.approx(wanted if wanted <= 1.0 else math.inf, abs=1e-5)


def test_the_sixteen_beams_stand_and_look_as_in_the_published_table(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    beams = sonar_of(make_world(), p3dx).beams()
    headings = [round(math.degrees(b.yaw)) for b in beams]
    assert headings == [90, 50, 30, 10, -10, -30, -50, -90, -90, -130, -150, -170, 170, 150, 130, 90]
    assert (beams[3].x, beams[3].y) == pytest.approx((0.166, 0.027))
    assert (beams[12].x, beams[12].y) == pytest.approx((-0.255, 0.027))


def test_too_near_is_the_least_range_and_too_far_is_no_echo(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world(WALL)
    world.place("R2", Pose2(0.8, 0.0, 0.0))  # sonars 3 and 4 are 0.034 m from the wall
    values = sonar_of(world, p3dx).read().values
    assert values[3] == values[4] == 0.1
    world.place("R2", Pose2(-0.3, 0.0, 0.0))
    assert all(v == math.inf for v in sonar_of(world, p3dx).read().values)
    assert min(sonar_of(world, p3dx, range=[0.1, 2.0]).read().values) == pytest.approx(1.3 - 0.166, abs=2e-2)


def test_it_sees_other_robots_and_not_itself(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world(others=("R1",))
    world.place("R1", Pose2(5.0, 5.0, 0.0))
    sonar = sonar_of(world, p3dx)
    assert all(v == math.inf for v in sonar.read().values)
    world.place("R1", Pose2(0.9, 0.0, math.pi))
    assert min(sonar.measure().values) == pytest.approx(0.9 - 0.183 - 0.166, abs=0.02)


def test_a_reading_is_of_the_instant_it_is_read(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world(WALL)
    world.place("R2", Pose2(0.2, 0.0, 0.0))
    make_device(world, "R2", "wheels", "velocity", p3dx.actuators[0].arguments).command((0.5, 0.5))
    sonar = sonar_of(world, p3dx)
    first, x = sonar.read(), world.pose("R2").x
    world.advance(40)
    second = sonar.read()
    assert (first.stamp, second.stamp) == (0.0, pytest.approx(0.2))
    moved = world.pose("R2").x - x
    assert moved > 0.03
    assert first.values[3] - second.values[3] == pytest.approx(moved, rel=0.03)


def test_reading_changes_nothing_in_the_world(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    def play(read: bool) -> list[float]:
        world = make_world(WALL)
        world.place("R2", Pose2(0.3, 0.1, 0.2))
        world.data.qvel[0:2] = 0.4, 0.1
        sensors = [make_device(world, "R2", s.name, s.driver, s.arguments) for s in p3dx.sensors]
        for _ in range(20):
            world.advance(10)
            if read:
                for sensor in sensors:
                    sensor.read()
                world.clearance("R2")
        return list(world.data.qpos.tolist())

    assert play(read=True) == play(read=False)


def test_twist_attitude_and_height_are_the_truth_of_a_tilted_body(make_world: MakeWorld) -> None:
    world = make_world()
    body, pose = world.body("R2"), Pose3(0.4, -0.2, 0.7, 0.3, -0.5, 1.1)
    forward, left, up, rate = 0.6, -0.3, 0.2, 0.9
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, np.array(pose.quaternion))
    world.data.qpos[body.q : body.q + 7] = [*pose[:3], *pose.quaternion]
    world.data.qvel[body.v : body.v + 3] = c * forward - s * left, s * forward + c * left, up
    world.data.qvel[body.v + 3 : body.v + 6] = rotation.reshape(3, 3).T @ [0.2, -0.4, rate]  # body frame
    sensors = {name: make_device(world, "R2", name, name, {}) for name in ("twist", "attitude", "height")}
    found = {name: sensor.read().values for name, sensor in sensors.items()}
    assert found["twist"] == pytest.approx([forward, left, up, rate])
    assert found["attitude"] == pytest.approx([0.3, -0.5])
    assert found["height"] == [0.7]


def test_noise_of_a_twist_sensor(make_world: MakeWorld) -> None:
    world, noise = make_world(), {"speed_noise": 0.02, "turn_noise": 0.1}
    sensor = make_device(world, "R2", "twist", "twist", noise)
    assert sensor.read().values == sensor.read().values, "a second reading of the same instant is equal"

    def later() -> list[float]:
        world.advance(1)
        return np.subtract(sensor.read().values, world.twist3("R2")).tolist()

    spread = np.std([later() for _ in range(2000)], axis=0)
    assert spread == pytest.approx([0.02, 0.02, 0.02, 0.1], rel=0.1)
    with pytest.raises(InputError, match=r"does not take 'noise'. Use speed_noise and turn_noise"):
        make_device(world, "R2", "twist", "twist", {}, noise=0.1)


def test_a_mock_robot_measures_its_commanded_twist() -> None:
    limits = {axis: Axis(max_speed=1.0, max_acceleration=1.0) for axis in ("vx", "vy", "vz")}
    limits["wz"] = TurnAxis(max_speed=1.0, max_acceleration=1.0)
    robot = FlatRobot(FlatWorld(SimulatedClock(0.05)), make_locomotion("flying", **limits), Pose2(0.0, 0.0))
    robot.motion = [0.1, 0.2, 0.3, 0.4]
    assert make_device(robot.world, robot.name, "twist", "twist", {}).read().values == [0.1, 0.2, 0.3, 0.4]
    noisy = make_device(robot.world, robot.name, "twist", "twist", {"speed_noise": 0.1}).read().values
    assert noisy[0] != 0.1
    assert noisy[3] == 0.4
    assert make_device(robot.world, robot.name, "attitude", "attitude", {}).read().values == [0.0, 0.0]
    assert make_device(robot.world, robot.name, "height", "height", {}).read().values == [0.0]


def test_noise_is_the_sensors_own_and_repeats(make_world: MakeWorld) -> None:
    def draw(seed: int) -> list[float]:
        world, rng, found = make_world(), np.random.default_rng(seed), []
        sensor = make_device(world, "R2", "position", "position", {}, noise=0.1, rng=rng)
        for _ in range(200):
            found += sensor.read().values[:2]
            assert sensor.read().values[:2] == found[-2:], "a second look at the same instant says the same"
            world.advance(1)
        return found

    assert draw(1) == draw(1) != draw(2)
    assert np.std(draw(1)) == pytest.approx(0.1, rel=0.15)


def test_unknown_sites_are_told(p3dx: RobotSpec) -> None:
    spec = next(s for s in p3dx.sensors if s.name == "sonar")
    assert p3dx.model is not None
    arena, given = p3dx.model.parents[2] / "scenarios" / "worlds" / "arena_box.xml", {**spec.arguments}
    mount = sensor_mount("sonar", "range_cone", {**given, "sites": ["sonar0", "sonar99"]})
    with pytest.raises(InputError, match="no site for sensor 'sonar' is named 'sonar99'"):
        compose_world(arena, [RobotInstance("R2", p3dx.model, [mount])])


CONE = math.radians(20.0)


@pytest.mark.parametrize(
    ("axis", "target", "seen"),
    [
        ("1 0 0", "1 0 0.3", True),  # 17 deg up
        ("1 0 0", "1 0 -0.3", True),
        ("1 0 0", "1 0.3 0", True),
        ("1 0 0", "1 0.25 0.25", True),
        ("1 0 0", "1 0 0.5", False),
        ("0 0 -1", "0 0.3 -1", True),
        ("0 0 -1", "0.3 0 -1", True),
        ("0 0 -1", "0.5 0 -1", False),
        ("1 0 -1", "1 0 -0.6", True),  # 14 deg over the axis
        ("1 0 -1", "1 0 -0.2", False),
    ],
)
def test_layers_spread_the_rays_of_a_beam_in_all_directions(tmp_path: Path, axis: str, target: str, seen: bool) -> None:
    robot, world = tmp_path / "robot.xml", tmp_path / "world.xml"
    robot.write_text(
        '<mujoco><worldbody><body name="base"><freejoint/><geom name="hull" size="0.01"/>'
        f'<site name="eye" zaxis="{axis}"/></body></worldbody></mujoco>'
    )
    x, y, z = map(float, target.split())
    world.write_text(f'<mujoco><worldbody><geom name="ball" size="0.09" pos="{x} {y} {z + 2.0}"/></worldbody></mujoco>')
    parameters = {"sites": ["eye"], "range": [0.0, 3.0], "half_angle": CONE, "rays": 9, "layers": 9}
    found = compose_world(world, [RobotInstance("R", robot, [sensor_mount("cone", "range_cone", parameters)])])
    found.data.qpos[2] = 2.0
    assert math.isfinite(make_device(found, "R", "cone", "range_cone", parameters).read().values[0]) == seen


class Tilt(MujocoSensor):
    """A user's own driver: the tilt of the base, through a site that it adds to the model itself."""

    height: Metres

    def prepare(self, model: Any, name: str) -> None:
        model.body("base").add_site(name=name, pos=[0.0, 0.0, self.height])

    def sample(self) -> list[float]:
        world = self.world
        world.update_poses()
        return [float(world.data.site(f"{self.robot}/{self.name}").xpos[2])]


def test_a_sensor_that_no_robot_has_yet_has_an_empty_name() -> None:
    assert RangeCone(sites=("front",), range=(0.1, 1.0)).name == ""


def test_a_users_own_driver_fits_in(p3dx: RobotSpec) -> None:
    assert p3dx.model is not None
    arena = p3dx.model.parents[2] / "scenarios" / "worlds" / "arena_box.xml"
    world = compose_world(arena, [RobotInstance("R2", p3dx.model, [sensor_mount("tilt", Tilt, {"height": 0.3})])])
    sensor = make_device(world, "R2", "tilt", Tilt, {"height": 0.3})
    assert sensor.read().values == pytest.approx([0.3975])


def test_the_beams_of_the_quadrotor_look_ahead_up_and_down(tmp_path) -> None:
    robot = load_robot(ROOT / "robots" / "quadrotor" / "robot.toml")
    cones = [s for s in robot.sensors if s.driver == "range_cone"]
    mounts = [sensor_mount(s.name, s.driver, s.arguments) for s in cones]
    (tmp_path / "arena.xml").write_text(EMPTY.format(""))
    assert robot.model is not None
    world = compose_world(tmp_path / "arena.xml", [RobotInstance("R", robot.model, mounts)])
    sensors = {s.name: make_device(world, "R", s.name, s.driver, s.arguments) for s in cones}
    elevations = {
        site: round(math.degrees(beam.elevation))
        for sensor in sensors.values()
        if isinstance(sensor, RangeCone)
        for site, beam in zip(sensor.sites, sensor.beams(), strict=True)
    }
    assert (elevations["up"], elevations["down"]) == (90, -90)
    assert {e for site, e in elevations.items() if site not in ("up", "down")} == {3, -67}
