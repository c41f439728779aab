"""Composing, contacts and clearances."""

from __future__ import annotations

import hashlib
import math
import subprocess
import sys
import threading
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import RobotSpec
from rocs_bt.devices.mujoco import MujocoWorld, RobotInstance, compose_world
from rocs_bt.devices.mujoco.body import hull_outline, outlines

MakeWorld = Callable[..., MujocoWorld]

ROOT = Path(__file__).parents[2]
ARENA = ROOT / "scenarios" / "worlds" / "arena_box.xml"
WALL = '<geom name="wall" type="box" size="0.05 3 0.25" pos="1.05 0 0.25"/>'


def drive(world: MujocoWorld, p3dx: RobotSpec, robot: str, speed: float) -> None:
    p3dx.actuators[0].parameters.bind("wheels", world, robot).command((speed, speed))


def test_the_hull_is_the_true_outline(make_world: MakeWorld) -> None:
    world = make_world()
    points = hull_outline(world.model, world.robots["R2"].hull)
    xs, ys = [p[0] for p in points], [p[1] for p in points]
    assert (max(xs) - min(xs), max(ys) - min(ys)) == pytest.approx((0.455, 0.381), abs=1e-6)
    for geom in world.robots["R2"].geoms:  # nothing that collides sticks out of it
        if world.model.geom_contype[geom] and geom not in world.robots["R2"].hull:
            reach = world.model.geom_aabb[geom][3:]
            assert abs(world.model.body_pos[world.model.geom_bodyid[geom]][1]) + min(reach) <= 0.1905


def test_the_arena_is_as_decoded() -> None:
    world = compose_world(ARENA, [])
    found = {o.name: o.points for o in outlines(world.model, world.robots)}
    assert sorted(found) == ["box", "wall_east", "wall_north", "wall_south", "wall_west"]
    assert min(x for x, _ in found["wall_east"]) == pytest.approx(2.475)
    assert max(y for _, y in found["wall_south"]) == pytest.approx(-2.425)
    assert sorted(found["box"])[0] == pytest.approx((-0.75, 0.75))


def test_clearance_is_hull_to_nearest_thing(make_world: MakeWorld) -> None:
    world = make_world(WALL, others=("R1",))
    world.place("R1", Pose2(-3.0, 0.0, 0.0))
    world.place("R2", Pose2(0.0, 0.0, 0.0))
    assert world.clearance("R2") == (pytest.approx(1.0 - 0.183, abs=1e-6), "wall")
    world.place("R2", Pose2(-2.0, 0.0, 0.0))
    assert world.clearance("R2") == (pytest.approx(1.0 - 0.272 - 0.183, abs=1e-6), "R1")
    assert world.clearance("R2", limit=0.3) == (0.3, "")
    assert world.clearance("R2", among="robots") == world.clearance("R2")
    assert world.clearance("R2", among="obstacles") == (pytest.approx(3.0 - 0.183, abs=1e-6), "wall")
    world.place("R2", Pose2(0.9, 0.0, 0.0))
    assert world.clearance("R2")[0] == pytest.approx(-0.083, abs=1e-3)


def test_room_is_from_things_that_cannot_move(make_world: MakeWorld) -> None:
    world = make_world(WALL, others=("R1",))
    world.place("R1", Pose2(0.5, 0.0, 0.0))
    assert world.room(0.4, 0.0) == pytest.approx(0.6)
    assert world.room(1.05, 0.0) == 0.0


@pytest.mark.parametrize(("speed", "driven"), [(0.08, False), (0.15, True), (0.5, True)])
def test_running_into_a_wall_is_one_contact(make_world: MakeWorld, p3dx: RobotSpec, speed: float, driven: bool) -> None:
    world = make_world(WALL)
    world.place("R2", Pose2(0.75, 0.0, 0.0))
    drive(world, p3dx, "R2", speed)
    found = []
    for _ in range(60):
        world.advance(10)
        found += world.contacts()
    assert [(c.robot, c.other, c.driven) for c in found] == [("R2", "wall", driven)]


def test_a_contact_of_any_single_step_is_found(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    """However many steps are taken at once, the period in which the wall is touched reports it."""

    def touched_at(steps: int) -> list[float]:
        world = make_world(WALL)
        world.place("R2", Pose2(0.75, 0.0, 0.0))
        drive(world, p3dx, "R2", 0.5)
        found: list[float] = []
        while len(found) < 1:
            world.advance(steps)
            found += [c.t for c in world.contacts()]
        return found

    (exact,) = touched_at(1)
    step = round(exact / 0.005)
    for steps in {step, *(n for n in range(2, 11) if step % n == 0), 7, 10}:
        assert touched_at(steps) == [pytest.approx(exact)]


@pytest.mark.parametrize("seed", range(6))
def test_the_nearest_of_many_things_is_that_of_all_distances(make_world: MakeWorld, seed: int) -> None:
    rng = np.random.default_rng(seed)
    around = zip(
        np.linspace(0.0, 2.0 * math.pi, 14), rng.uniform(0.05, 2.5, 14), rng.uniform(0.9, 1.3, 14), strict=True
    )
    # All within reach and of all sizes, so that the nearest centre is seldom that of the nearest surface.
    posts = [(5.0 + (gap + r) * math.cos(a), -3.0 + (gap + r) * math.sin(a), r) for a, r, gap in around]
    geom = '<geom name="post{}" type="cylinder" size="{} 0.2" pos="{} {} 0.2"/>'
    world = make_world("".join(geom.format(i, r, x, y) for i, (x, y, r) in enumerate(posts)))
    world.place("R2", Pose2(5.0, -3.0).compose(Pose2(*rng.uniform(-0.3, 0.3, 3))))
    found, _ = world.clearance("R2")
    gaps = [
        mujoco.mj_geomDistance(world.model, world.data, hull, world.model.geom(f"post{i}").id, 100.0, None)
        for i in range(len(posts))
        for hull in world.robots["R2"].hull
    ]
    assert found == pytest.approx(min(gaps), abs=1e-6)


def test_a_robot_that_stands_still_is_struck(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world(others=("R1",))
    world.place("R1", Pose2(-0.8, 0.0, 0.0))
    drive(world, p3dx, "R1", 0.3)
    found = []
    for _ in range(40):
        world.advance(10)
        found += world.contacts()
    assert {(c.robot, c.other): c.driven for c in found} == {("R2", "R1"): False, ("R1", "R2"): True}


def test_a_robot_pushed_into_a_wall_does_not_drive_into_it(make_world: MakeWorld, p3dx: RobotSpec) -> None:
    world = make_world('<geom name="wall" type="box" size="0.05 3 0.25" pos="0.35 0 0.25"/>', others=("R1",))
    world.place("R1", Pose2(-0.8, 0.0, 0.0))
    drive(world, p3dx, "R1", 1.0)
    found = []
    for _ in range(60):
        world.advance(10)
        found += world.contacts()
    assert ("R2", "wall", False) in [(c.robot, c.other, c.driven) for c in found]


PLAY = """
import hashlib, sys
from pathlib import Path
sys.path.insert(0, {tests!r})
from rocs_bt.catalog import load_robot
from rocs_bt.devices.mujoco import RobotInstance, compose_world
from rocs_bt.base.geometry import Pose2
p3dx = load_robot(Path({robot!r}))
world = compose_world(Path({arena!r}), [RobotInstance("R2", p3dx.model), RobotInstance("R1", p3dx.model)])
world.place("R2", Pose2(-1.0, 2.0, 0.3)); world.place("R1", Pose2(0.2, 2.1, 3.0))
for name, speeds in (("R2", (0.4, 0.3)), ("R1", (0.3, 0.35))):
    p3dx.actuators[0].parameters.bind("wheels", world, name).command(speeds)
digest = hashlib.sha256()
for _ in range(80):
    world.advance(10); world.digest(digest)
print(digest.hexdigest())
"""


def test_the_same_drive_gives_the_same_bits_in_another_process() -> None:
    robot = str(ROOT / "robots" / "pioneer_p3dx" / "robot.toml")
    code = PLAY.format(tests=str(ROOT), robot=robot, arena=str(ARENA))
    runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(2)]
    assert len(runs[0].stdout.strip()) == 64
    assert runs[0].stdout == runs[1].stdout


def test_the_digest_follows_the_state(make_world: MakeWorld) -> None:
    world = make_world()
    first, second = hashlib.sha256(), hashlib.sha256()
    world.digest(first)
    world.place("R2", Pose2(0.0, 0.0, 1e-9))
    world.digest(second)
    assert first.hexdigest() != second.hexdigest()


def test_it_can_be_read_while_another_thread_steps(make_world: MakeWorld) -> None:
    world, stop = make_world(WALL), threading.Event()

    def step() -> None:
        while not stop.is_set():
            world.advance(1)

    thread = threading.Thread(target=step)
    thread.start()
    try:
        for _ in range(300):
            assert world.clearance("R2")[0] == pytest.approx(1.0 - 0.183, abs=1e-3)
    finally:
        stop.set()
        thread.join()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("<mujoco><worldbody><geom", "not a valid MJCF model"),
        ("<mujoco><worldbody><geom type='cube'/></worldbody></mujoco>", "not a valid MJCF model"),
        ("<mujoco><worldbody/></mujoco>", "root body must be named 'base', found none"),
        (
            "<mujoco><worldbody><body name='base'><geom size='1'/></body></worldbody></mujoco>",
            "'base' has no free joint",
        ),
    ],
)
def test_a_wrong_robot_model_is_told(tmp_path: Path, text: str, message: str) -> None:
    model = tmp_path / "robot.xml"
    model.write_text(text)
    with pytest.raises(InputError, match=message) as error:
        compose_world(ARENA, [RobotInstance("R2", model)])
    assert error.value.faults[0].file == model


def test_a_missing_world_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="there is no such model file"):
        compose_world(tmp_path / "nowhere.xml", [])


def test_a_robots_own_options_do_not_change_the_world(tmp_path: Path) -> None:
    model = tmp_path / "robot.xml"
    model.write_text(
        "<mujoco><option timestep='0.1' gravity='0 0 0'/><worldbody><body name='base'><freejoint/>"
        "<geom size='0.1'/></body></worldbody></mujoco>"
    )
    world = compose_world(ARENA, [RobotInstance("R2", model)], step=0.004)
    assert world.step == 0.004
    assert world.model.opt.gravity[2] == pytest.approx(-9.81)
    assert math.isclose(world.model.opt.timestep, 0.004)
