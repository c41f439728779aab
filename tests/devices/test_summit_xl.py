"""The skid-steer robot slips as Coulomb's law says, stands still on its contacts, and shares a world with another."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import RobotSpec, load_robot
from rocs_bt.devices.mujoco import MujocoWorld, RobotInstance, compose_world
from rocs_bt.interfaces.device import Actuator
from tests.made_devices import make_device, sensor_mount

ROOT = Path(__file__).parents[2]
BASE, TRACK = 0.446, 0.408  # [m] between axles, between wheels
SLIP = 1.0 / (1.0 + (BASE / TRACK) ** 2)  # four equal Coulomb contacts: the turn's share of a differential drive's
WEIGHT = 65.0 * 9.81
MakeWorld = Callable[..., MujocoWorld]


@pytest.fixture(scope="module")
def summit() -> RobotSpec:
    return load_robot(ROOT / "robots" / "summit_xl" / "robot.toml")


@pytest.fixture
def make_summit_world(tmp_path: Path, summit: RobotSpec, p3dx: RobotSpec) -> MakeWorld:
    def make(geoms: str = "", other: bool = False, step: float = 0.005) -> MujocoWorld:
        arena = tmp_path / "arena.xml"
        arena.write_text(
            f'<mujoco><worldbody><geom name="floor" type="plane" size="0 0 1"/>{geoms}</worldbody></mujoco>'
        )
        assert summit.model is not None
        assert p3dx.model is not None
        mounts = [sensor_mount(s.name, s.driver, s.arguments) for s in summit.sensors]
        robots = [RobotInstance("R3", summit.model, mounts), *([RobotInstance("R1", p3dx.model)] if other else [])]
        return compose_world(arena, robots, step=step)

    return make


def wheels_of(world: MujocoWorld, robot: RobotSpec, name: str = "R3") -> Actuator:
    return make_device(world, name, "wheels", "velocity", robot.actuators[0].arguments)


def normal_forces(world: MujocoWorld, steps: int) -> np.ndarray:
    """The sum of all normal forces [N], step by step."""
    import mujoco

    sums, force = [], np.zeros(6)
    for _ in range(steps):
        world.advance(1)
        total = 0.0
        for contact in range(world.data.ncon):
            mujoco.mj_contactForce(world.model, world.data, contact, force)
            total += force[0]
        sums.append(total)
    return np.array(sums)


@pytest.mark.parametrize("step", [0.002, 0.005])
@pytest.mark.parametrize(("left", "right"), [(-0.15, 0.15), (0.5, -0.5), (-1.5, 1.5), (0.2, 0.6), (1.2, 1.0)])
def test_it_turns_as_coulomb_friction_says_and_does_not_chatter(
    make_summit_world: MakeWorld, summit: RobotSpec, left: float, right: float, step: float
) -> None:
    world = make_summit_world(step=step)
    wheels = wheels_of(world, summit)
    wheels.command([left, right, left, right])
    world.advance(round(1.5 / step))
    forces = normal_forces(world, round(0.5 / step))
    true = wheels.measured()
    rate = world.twist("R3").turn
    assert rate / ((true[1] - true[0]) / TRACK) == pytest.approx(SLIP, rel=0.03)
    assert 0.45 * 0.97 <= rate / ((true[1] - true[0]) / TRACK) <= 0.456 * 1.03
    assert summit.locomotion.twist(np.array(true)).turn == pytest.approx(rate, rel=0.01)
    assert forces.mean() == pytest.approx(WEIGHT, rel=0.01)
    assert forces.std() < 0.01 * WEIGHT
    assert world.data.ncon == 4


@pytest.mark.parametrize("speed", [-0.3, 0.5, 3.0])
def test_it_drives_straight_at_nearly_the_rims_speed(
    make_summit_world: MakeWorld, summit: RobotSpec, speed: float
) -> None:
    world = make_summit_world()
    wheels_of(world, summit).command([speed] * 4)
    world.advance(500)
    twist = world.twist("R3")
    assert twist.forward == pytest.approx(speed, rel=0.006)  # the contacts sag by 1.3 mm
    assert abs(twist.turn) < 1e-3
    assert abs(world.pose("R3").y) < 1e-3


def test_a_reversal_does_not_make_it_hop(make_summit_world: MakeWorld, summit: RobotSpec) -> None:
    world = make_summit_world()
    wheels = wheels_of(world, summit)
    world.advance(100)
    for left, right in ((0.5, 0.5), (-0.35, -0.35), (1.1, -1.1), (-1.1, 1.1), (0.0, 0.0)):
        wheels.command([left, right, left, right])
        for _ in range(120):
            world.advance(1)
            assert world.data.ncon == 4


def test_its_three_sensors_see_ahead_to_both_sides_and_nothing_of_itself(
    make_summit_world: MakeWorld, summit: RobotSpec
) -> None:
    spec = next(s for s in summit.sensors if s.driver == "range_cone")
    posts = {
        "left": (0.9, 0.55),
        "ahead": (1.0, -0.012),
        "right": (0.9, -0.45),
        "behind": (-0.6, 0.0),
        "abeam": (0, 0.6),
    }
    seen = {}
    for name, (x, y) in posts.items():
        world = make_summit_world(f'<geom type="cylinder" size="0.03 0.5" pos="{x} {y} 0.5"/>')
        values = make_device(world, "R3", "ranges", spec.driver, spec.arguments).read().values
        seen[name] = [i for i, v in enumerate(values) if v < 1.0]
    assert seen == {"left": [0], "ahead": [1], "right": [2], "behind": [], "abeam": []}


def test_two_kinds_of_robots_share_a_world_and_see_and_touch_each_other(
    make_summit_world: MakeWorld, summit: RobotSpec, p3dx: RobotSpec
) -> None:
    world = make_summit_world(other=True)
    world.place("R1", Pose2(1.2, 0.0, 3.14))
    spec = next(s for s in summit.sensors if s.driver == "range_cone")
    ranges = make_device(world, "R3", "ranges", spec.driver, spec.arguments)
    # The other one's nose is 0.183 m before its axle.
    assert ranges.read().values[1] == pytest.approx(1.2 - 0.183 - 0.338, abs=0.02)
    assert world.clearance("R3")[0] == pytest.approx(1.2 - 0.183 - 0.35, abs=0.01)
    mine, other = wheels_of(world, summit), wheels_of(world, p3dx, "R1")
    mine.command([0.3] * 4)
    other.command([0.0, 0.0])
    world.advance(700)
    assert {(c.robot, c.other, c.driven) for c in world.contacts()} == {("R3", "R1", True), ("R1", "R3", False)}
    assert world.pose("R1").x > 1.25, "the heavier one pushes"
