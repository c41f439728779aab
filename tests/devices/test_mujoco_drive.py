"""The shipped robot drives as its kinematics say, and stops when nobody commands it."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from rocs_bt.base.errors import DeviceError, UnknownName
from rocs_bt.base.geometry import Pose2, wrap_angle
from rocs_bt.catalog import RobotSpec
from rocs_bt.devices.mujoco import MujocoWorld
from rocs_bt.event import ListSink
from rocs_bt.interfaces.device import Actuator
from rocs_bt.interfaces.safety_gate import SafetyGate
from tests.made_devices import make_device

MakeWorld = Callable[..., MujocoWorld]


def wheels_of(world: MujocoWorld, p3dx: RobotSpec, robot: str = "R2") -> Actuator:
    return make_device(world, robot, "wheels", "velocity", p3dx.actuators[0].arguments)


def settle(world: MujocoWorld, wheels: Actuator, speeds: tuple[float, float]) -> None:
    wheels.command(speeds)
    world.advance(200)


def test_the_robot_stands_on_three_points(make_world: MakeWorld) -> None:
    world = make_world()
    world.advance(100)
    pairs = {tuple(sorted(world.model.geom(g).name for g in pair)) for pair in world.data.contact.geom.tolist()}
    assert pairs == {("R2/caster", "floor"), ("R2/left_wheel", "floor"), ("R2/right_wheel", "floor")}
    assert world.data.ncon == 3
    assert world.contacts() == []


@pytest.mark.parametrize("step", [0.002, 0.005])
@pytest.mark.parametrize(
    "speeds", [(0.5, 0.5), (-0.3, -0.3), (0.2, -0.2), (-0.4, 0.4), (0.1, 0.3), (0.5, 0.4), (1.2, 1.2)]
)
def test_it_follows_its_kinematics(
    make_world: MakeWorld, p3dx: RobotSpec, speeds: tuple[float, float], step: float
) -> None:
    world = make_world(step=step)
    settle(world, wheels_of(world, p3dx), speeds)
    wanted = p3dx.locomotion.twist(np.array(speeds))
    before, path, turned, period = world.pose("R2"), 0.0, 0.0, 10 * step
    for _ in range(40):
        world.advance(10)
        pose = world.pose("R2")
        path += before.distance(pose)
        turned += wrap_angle(pose.yaw - before.yaw)
        before = pose
    assert turned == pytest.approx(wanted.turn * 40 * period, rel=0.005, abs=1e-4)

    assert path == pytest.approx(
        abs(wanted.forward) * 40 * period, rel=0.005, abs=5e-3
    )  # a spin on the spot drifts by millimetres


def test_a_step_command_does_not_make_it_pitch_or_slip(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world()
    wheels = wheels_of(world, p3dx)
    lowest, most = 1.0, 0
    for speeds in ((0.5, 0.5), (-0.35, -0.35), (0.5, -0.5), (0.0, 0.0)):
        wheels.command(speeds)
        for _ in range(120):
            world.advance(1)
            _, x, y, _ = world.data.qpos[3:7]
            lowest = min(lowest, 1.0 - 2.0 * (x * x + y * y))  # the cosine of its tilt
            most = max(most, world.data.ncon)
    assert math.acos(min(lowest, 1.0)) < math.radians(1.0)
    assert most == 3


def test_it_brakes_as_fast_as_its_electronics_allow(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world()
    wheels = wheels_of(world, p3dx)
    settle(world, wheels, (0.5, 0.5))
    x = world.pose("R2").x
    wheels.neutral()
    world.advance(100)
    assert world.pose("R2").x - x == pytest.approx(0.5**2 / (2 * 3.0), abs=0.01)
    assert abs(world.twist("R2").forward) < 1e-3


def test_encoders_tell_rim_speeds_and_mind_the_signs(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world()
    settle(world, wheels_of(world, p3dx), (0.3, -0.1))
    parameters = next(s for s in p3dx.sensors if s.name == "encoders").arguments
    plain = make_device(world, "R2", "encoders", "wheel_speed", parameters)
    assert plain.read().values == pytest.approx([0.3, -0.1], abs=2e-3)
    turned = make_device(world, "R2", "encoders", "wheel_speed", {**parameters, "signs": [1, -1]})
    assert turned.read().values == pytest.approx([0.3, 0.1], abs=2e-3)


def test_a_motor_mounted_the_other_way_round_goes_the_other_way(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world()
    parameters = {**p3dx.actuators[0].arguments, "signs": [1, -1]}
    settle(world, make_device(world, "R2", "wheels", "velocity", parameters), (0.2, -0.2))
    assert world.twist("R2").forward == pytest.approx(0.2, abs=2e-3)
    assert world.twist("R2").turn == pytest.approx(0.0, abs=2e-3)


@pytest.mark.parametrize("max_age", [0.2, 0.05])
def test_a_silent_mind_stops_within_a_step_of_its_expiry(
    make_world: MakeWorld, p3dx: RobotSpec, max_age: float
) -> None:
    world = make_world()
    sink, limits = ListSink(), p3dx.actuators[0].limits
    gate = SafetyGate(wheels_of(world, p3dx), world.clock, limits, period=0.05, max_age=max_age, sink=sink)
    world.guard(gate)
    for _ in range(40):
        gate.command((0.3, 0.3))
        world.advance(10)
    assert sink.events == []
    last = world.clock.now() - 0.05
    world.advance(200)
    (expired,) = sink.events
    assert 0.0 < expired.t - (last + max_age) <= world.step + 1e-9
    assert abs(world.twist("R2").forward) < 1e-3
    assert not world.commanded("R2")


def test_a_wrong_command_is_refused(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    wheels = wheels_of(make_world(), p3dx)
    with pytest.raises(DeviceError, match="takes 2 wheel speeds, found 3"):
        wheels.command((0.1, 0.1, 0.1))


def test_unknown_names_list_what_exists(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world()
    with pytest.raises(UnknownName, match=r"no robot is named 'R3'.*R2"):
        world.pose("R3")
    parameters = {**p3dx.actuators[0].arguments, "motors": ["left_moter", "right_motor"]}
    with pytest.raises(UnknownName, match=r"'left_moter'.*Did you mean 'left_motor'"):
        make_device(world, "R2", "wheels", "velocity", parameters)


def test_place_puts_a_robot_there_at_rest(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world()
    settle(world, wheels_of(world, p3dx), (0.3, 0.1))
    world.place("R2", Pose2(1.0, -2.0, 2.5))
    assert world.pose("R2") == pytest.approx(Pose2(1.0, -2.0, 2.5))
    assert world.twist("R2") == pytest.approx((0.0, 0.0, 0.0))
