"""The humanoid shifts its weight, walks and turns as commanded, and stays on its feet when it is pushed."""

from __future__ import annotations

import math
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.geometry import Twist2, wrap_angle
from rocs_bt.base.python_content import load_module
from rocs_bt.check import check_content
from rocs_bt.simulation.fall import FallWatch
from tests.robots.walker import CATALOG, Walker

LEGS = CATALOG.load_robot("humanoid").file.parent / "legs.py"
MakeWalker = Callable[..., Walker]


@pytest.fixture
def walker(tmp_path: Path) -> MakeWalker:
    return lambda geoms="": Walker("humanoid", tmp_path, geoms)


def soles(robot: Walker) -> list[float]:
    """Heights of the middles of both soles [m]."""
    data = robot.world.data
    robot.world.update_poses()
    return [float(data.geom(f"R/{side}_foot").xpos[2]) - 0.0125 for side in ("left", "right")]


def test_it_stands_still_on_both_feet(walker: MakeWalker) -> None:
    robot = walker()
    robot.wait(1.0)
    start = robot.world.pose("R")
    for _ in range(20):
        robot.wait(0.5)
        assert max(soles(robot)) < 0.003
    end = robot.world.pose("R")
    assert start.distance(end) < 0.003
    assert abs(wrap_angle(end.yaw - start.yaw)) < math.radians(0.5)
    assert robot.tilt < math.radians(2.0)


def test_it_shifts_its_weight_before_it_lifts_a_foot(walker: MakeWalker) -> None:
    robot = walker()
    robot.wait(1.0)
    robot.gait.command([0.1, 0.0, 0.0])
    while max(soles(robot)) < 0.01:
        robot.wait(0.05)
        assert robot.world.stamp < 3.0, "it lifts a foot"
    lifted = int(np.argmax(soles(robot)))
    left = robot.world.data.body("R/left_foot").xpos[1], robot.world.data.body("R/right_foot").xpos[1]
    mass = float(robot.world.data.subtree_com[robot.world.body("R").root][1])
    assert abs(mass - left[1 - lifted]) < 0.75 * abs(mass - left[lifted]), "it is over the foot that stays"


@pytest.mark.parametrize("twist", [Twist2(0.2), Twist2(0.0, left=0.08), Twist2(0.0, turn=0.8)], ids=str)
def test_walking_saturates_no_servo_for_more_than_one_per_cent_of_the_time(walker: MakeWalker, twist: Twist2) -> None:
    robot = walker()
    model, data = robot.world.model, robot.world.data
    saturated: list[np.ndarray] = []
    robot.go(twist, 1.0)
    robot.world.attach(
        lambda t: saturated.append(np.abs(data.actuator_force) > 0.999 * model.actuator_forcerange[:, 1])
    )
    robot.go(twist, 6.0)
    assert np.mean(saturated, axis=0).max() < 0.01


def test_its_masses_are_those_of_its_parts(walker: MakeWalker) -> None:
    model = walker().world.model
    masses = {name: float(model.body(f"R/{name}").mass[0]) for name in ("base", "left_hip", "left_thigh", "left_shin")}
    assert masses == pytest.approx({"base": 14.0, "left_hip": 0.6, "left_thigh": 1.7, "left_shin": 1.1})
    assert float(model.body("R/base").subtreemass[0]) == pytest.approx(22.0)
    assert sorted(model.body("R/base").inertia) == pytest.approx([0.118, 0.245, 0.330], abs=0.001)


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.soak) for seed in range(2, 12))])
def test_a_minute_of_random_commands_does_not_throw_it_over(walker: MakeWalker, seed: int) -> None:
    robot, rng = walker(), np.random.default_rng(seed)
    limit = robot.locomotion
    while robot.world.stamp < 60.0:
        forward, left, turn = rng.uniform(-1.0, 1.0, 3) * rng.integers(0, 2, 3)
        robot.go(Twist2(0.25 * forward, limit.turn_limit * turn, 0.08 * left), float(rng.uniform(0.2, 3.0)))
        assert robot.upright, f"after {robot.world.stamp:.1f} s"
    assert robot.tilt < math.radians(6.0)


def test_it_has_fallen_when_it_is_thrown_over(walker: MakeWalker) -> None:
    robot, watch, fallen = walker(), FallWatch(), False
    robot.wait(0.2)
    robot.push(600.0, 0.0)
    for k in range(160):
        robot.wait(0.05)
        fallen = fallen or watch.update(0.05 * k, robot.world.tilt("R"), robot.world.ground_contact("R"))
    assert fallen


@settings(max_examples=200, deadline=None)
@given(
    st.floats(-0.12, 0.12), st.floats(-0.1, 0.1), st.floats(-0.48, -0.35),
    st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.floats(-0.4, 0.4),
)  # fmt: skip  # position and attitude
def test_inverse_kinematics_places_the_foot(
    x: float, y: float, z: float, roll: float, pitch: float, yaw: float
) -> None:
    legs = load_module(LEGS)
    rotation = legs.rotation
    foot, ankle = rotation(roll, pitch, yaw), np.array([x, y, z])
    a, b, c, knee, d, e = legs.joint_angles(ankle, foot)
    thigh = rotation(0.0, 0.0, a) @ rotation(b, 0.0, 0.0) @ rotation(0.0, c, 0.0)
    shin = thigh @ rotation(0.0, knee, 0.0)
    assert np.allclose(shin @ rotation(0.0, d, 0.0) @ rotation(e, 0.0, 0.0), foot, atol=1e-9)
    assert np.allclose(thigh @ (0.0, 0.0, -0.26) + shin @ (0.0, 0.0, -0.26), ankle, atol=1e-9)


@pytest.mark.parametrize(
    ("valid", "wrong"),
    [("layers = 17", "layers = 0"), ('heights = ["-0.47 m", "0.60 m"]', 'heights = ["0.60 m", "-0.47 m"]')],
)
def test_a_scanner_without_layers_or_heights_is_a_fault_of_its_table(tmp_path: Path, valid: str, wrong: str) -> None:
    file = shutil.copytree(LEGS.parent, tmp_path / "robots" / "mine") / "robot.toml"
    text = file.read_text("utf-8")
    assert valid in text
    file.write_text(text.replace(valid, wrong), "utf-8")
    (fault,) = (fault for fault in check_content([file]).faults if not fault.warning)
    assert "needs at least one layer and heights that rise" in fault.message
    assert text.splitlines()[fault.line - 1] in ("[[sensor]]", 'name = "lidar"')
