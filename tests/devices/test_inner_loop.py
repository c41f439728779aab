"""An actuator's inner loop: an arm on a box, held upright by a PD controller at each physics step."""

from __future__ import annotations

import hashlib
from functools import partial

import mujoco
import numpy as np
import pytest

from rocs_bt.base.errors import ActuatorError, DeviceError, UnknownName
from rocs_bt.devices.mujoco import MujocoActuator, MujocoWorld, RobotInstance, compose_world
from rocs_bt.interfaces.actuator_limits import ActuatorLimits
from rocs_bt.interfaces.safety_gate import SafetyGate
from tests.made_devices import make_device

CRANE = """<mujoco model="crane">
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="base" pos="0 0 0.05">
      <freejoint name="base"/>
      <geom name="hull" type="box" size="0.15 0.15 0.05" mass="5"/>
      <site name="top" pos="0 0 0.05"/>
      <body name="arm" pos="0 0 0.06">
        <joint name="arm" type="hinge" axis="0 1 0"/>
        <geom name="arm" type="capsule" fromto="0 0 0 0 0 0.3" size="0.02" mass="0.5"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <motor name="arm" joint="arm" ctrlrange="-3 4"/>
    <general name="lift" site="top" gear="0 0 1 0 0 0"/>
  </actuator>
  <sensor>
    <gyro name="gyro" site="top"/>
    <velocimeter name="velocimeter" site="top"/>
    <accelerometer name="accelerometer" site="top"/>
    <subtreecom name="centre" body="base"/>
  </sensor>
</mujoco>"""


class Arm(MujocoActuator):
    """Holds the arm at the commanded angle, with noise on the torque."""

    size = 1
    raises: bool = False

    def set_up(self) -> None:
        self.controls = self.world.controls(self.robot, ["arm"])
        self.target = 0.0
        self.times: list[float] = []

    def command(self, values) -> None:
        self.target = values[0]

    def neutral(self) -> None:
        self.target = 0.0

    def before_step(self, t: float) -> None:
        self.times.append(t)
        world = self.world
        assert t == world.stamp
        assert list(world.pose3(self.robot)[:3]) == world.data.qpos[:3].tolist()
        assert world.pose(self.robot)[:2] == tuple(world.data.qpos[:2].tolist())
        angle, rate = world.joint_positions(self.controls), world.joint_velocities(self.controls)
        torque = 30.0 * (self.target - angle) - 1.0 * rate + self.rng.normal(0.0, 0.05)
        world.set_controls(self.controls, torque)
        if self.raises and t > 0.5:
            raise ZeroDivisionError("no angle")


@pytest.fixture
def world(tmp_path) -> MujocoWorld:
    (tmp_path / "robot.xml").write_text(CRANE)
    arena = tmp_path / "arena.xml"
    arena.write_text('<mujoco><worldbody><geom name="floor" type="plane" size="9 9 0.1"/></worldbody></mujoco>')
    return compose_world(arena, [RobotInstance("C", tmp_path / "robot.xml")], step=0.005)


def attached(world: MujocoWorld, seed: int = 1, **parameters) -> tuple[Arm, SafetyGate]:
    arm = make_device(world, "C", "arm", Arm, parameters, rng=np.random.default_rng(seed))
    assert isinstance(arm, Arm)
    gate = SafetyGate(arm, world.clock, ActuatorLimits((-1.0,), (1.0,)), period=0.05, max_age=0.2)
    world.attach(partial(gate.run, arm.before_step))
    world.watch_motion("C", gate)
    world.guard(gate)
    return arm, gate


@pytest.mark.parametrize(
    ("velocity", "commanded", "driven"),
    [
        ((0.0, 0.0, -0.3, 0.0, 0.0, 0.0), True, True),
        ((0.0, 0.0, 0.0, 0.0, -1.0, 0.0), True, True),
        ((0.0, 0.0, 0.0, 0.0, 0.0, 0.0), True, False),
        ((0.0, 0.0, -0.3, 0.0, 0.0, 0.0), False, False),
    ],
)
def test_a_robot_without_wheels_drives_into_what_it_lands_on_only_by_its_own_motion(
    tmp_path, velocity, commanded, driven
) -> None:
    (tmp_path / "robot.xml").write_text(CRANE)
    arena = tmp_path / "arena.xml"
    table = '<geom name="table" type="box" size="0.05 0.05 0.1" pos="0 0 0.1"/>'
    arena.write_text(f'<mujoco><option gravity="0 0 0"/><worldbody>{table}</worldbody></mujoco>')
    world = compose_world(arena, [RobotInstance("C", tmp_path / "robot.xml")], step=0.005)
    arm = make_device(world, "C", "arm", Arm, {}, rng=np.random.default_rng(1))
    gate = SafetyGate(arm, world.clock, ActuatorLimits((-1.0,), (1.0,)), period=0.05, max_age=0.2)
    world.watch_motion("C", gate)
    if commanded:
        gate.command([0.1])
    world.data.qpos[2] = 0.2505 if any(velocity) else 0.2499
    world.data.qvel[:6] = velocity
    found = []
    while not found and world.stamp < 1.0:
        world.advance(1)
        found = world.contacts()
    assert [(c.robot, c.other, c.driven) for c in found] == [("C", "table", driven)]


def angle_of(world: MujocoWorld) -> float:
    return float(world.joint_positions(world.controls("C", ["arm"]))[0])


def test_the_loop_runs_at_each_physics_step_and_holds_the_body_in_neutral_too(world: MujocoWorld) -> None:
    arm, gate = attached(world)
    for _ in range(20):
        gate.command([0.4])
        world.advance(10)
    assert np.array(arm.times) == pytest.approx(0.005 * np.arange(200), abs=1e-12)
    assert angle_of(world) == pytest.approx(0.4, abs=0.05)
    gate.shut()
    world.advance(200)
    assert len(arm.times) == 400
    assert angle_of(world) == pytest.approx(0.0, abs=0.05)


def test_without_its_loop_the_arm_falls(world: MujocoWorld) -> None:
    world.data.qvel[6] = 0.1
    world.advance(400)
    assert abs(angle_of(world)) > 1.0


def test_the_same_seed_gives_the_same_motion_and_another_seed_does_not(tmp_path, world: MujocoWorld) -> None:
    arena = tmp_path / "arena.xml"
    robots = [RobotInstance("C", tmp_path / "robot.xml")]

    def digest(seed: int, steps: int) -> str:
        world, found = compose_world(arena, robots, step=0.005), hashlib.sha256()
        _, gate = attached(world, seed)
        for _ in range(200 // steps):
            gate.command([0.2])
            world.advance(steps)
        world.digest(found)
        return found.hexdigest()

    assert digest(3, 10) == digest(3, 10) == digest(3, 20)
    assert digest(3, 10) != digest(4, 10)


def test_an_exception_is_a_failure_of_the_actuator_and_the_loop_goes_on(world: MujocoWorld) -> None:
    arm, gate = attached(world, raises=True)
    failures: list[ActuatorError] = []

    def failed(error: ActuatorError) -> None:
        failures.append(error)
        gate.shut()

    gate.on_failure = failed
    gate.command([0.3])
    world.advance(40)
    gate.command([0.3])
    world.advance(160)
    (failure,) = failures
    assert "ZeroDivisionError: no angle (test_inner_loop.py:" in str(failure)
    assert arm.target == 0.0
    assert len(arm.times) == 200
    with pytest.raises(DeviceError, match="shut after a failure"):
        gate.command([0.3])


def test_without_an_agent_the_exception_leaves_advance(world: MujocoWorld) -> None:
    attached(world, raises=True)
    with pytest.raises(ActuatorError, match="ZeroDivisionError: no angle"):
        world.advance(200)


def test_a_robot_without_wheels_is_commanded_while_its_motion_actuator_has_a_command(world: MujocoWorld) -> None:
    _, gate = attached(world)
    assert not world.commanded("C")
    gate.command([0.3])
    assert world.commanded("C")
    gate.command([0.0])
    assert not world.commanded("C")
    gate.command([0.3])
    world.advance(50)  # the watchdog
    assert not world.commanded("C")


def test_controls_have_ranges_and_refuse_values_that_do_not_fit(world: MujocoWorld) -> None:
    controls = world.controls("C", ("lift", "arm"))
    assert (controls.names, controls.low.tolist(), controls.high.tolist()) == (
        ("lift", "arm"),
        [-np.inf, -3.0],
        [np.inf, 4.0],
    )
    world.set_controls(controls, [7.0, -9.0])
    assert world.data.ctrl.tolist() == [-3.0, 7.0]
    assert np.isnan(world.joint_positions(controls)).tolist() == [True, False]
    assert np.isnan(world.joint_velocities(controls)).tolist() == [True, False]
    with pytest.raises(DeviceError, match=r"2 actuators take as many values, found the shape \(1,\)"):
        world.set_controls(controls, [1.0])
    with pytest.raises(DeviceError, match="the value of 'arm' is NaN"):
        world.set_controls(controls, [1.0, np.nan])
    with pytest.raises(UnknownName, match="Did you mean 'arm'"):
        world.controls("C", ["amr"])


def rows(world: MujocoWorld, *names: str) -> np.ndarray:
    """Addresses of sensors with three values."""
    return np.array([world.sensor_address("C", name) + i for name in names for i in range(3)])


def test_sensors_of_the_model_show_the_velocities_of_the_present_state(world):
    gyro, velocimeter = rows(world, "gyro"), rows(world, "velocimeter")
    world.data.qvel[:6] = 0.3, -0.2, 0.1, 0.5, 0.7, -0.9  # linear: world frame; angular: body frame
    world.data.qpos[2] = 1.0
    for _ in range(3):
        world.advance(2)
        linear, angular = world.data.qvel[:3].copy(), world.data.qvel[3:6].copy()
        rotation = np.zeros(9)
        mujoco.mju_quat2Mat(rotation, world.data.qpos[3:7])
        at_site = rotation.reshape(3, 3).T @ linear + np.cross(angular, [0.0, 0.0, 0.05])
        np.testing.assert_allclose(world.sensed(gyro), angular, atol=1e-12)
        np.testing.assert_allclose(world.sensed(velocimeter), at_site, atol=1e-12)


def test_sensors_of_the_model_of_every_stage_are_those_of_a_full_computation(world):
    asked = rows(world, "accelerometer", "centre", "velocimeter", "gyro")
    world.advance(3)
    sensed = world.sensed(asked)
    world.model.opt.disableflags = 0
    mujoco.mj_forward(world.model, world.data)
    np.testing.assert_allclose(sensed, world.data.sensordata[asked], atol=1e-9)
    assert np.linalg.norm(sensed) > 0.1


def test_reading_sensors_of_the_model_does_not_change_the_trajectory(world):
    asked, paths = rows(world, "accelerometer", "centre", "gyro"), []
    for read in (False, True):
        mujoco.mj_resetData(world.model, world.data)
        for _ in range(40):
            world.advance(2)
            if read:
                world.sensed(asked)
        paths.append(world.data.qpos.tobytes())
    assert paths[0] == paths[1]
