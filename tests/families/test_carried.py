"""Things that scripts carry: doors, boxes and people."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from rocs_bt import Catalog, Pose2, run
from rocs_bt.base.errors import InputError, UnknownName
from rocs_bt.base.toml_text import as_toml
from rocs_bt.base.units import Dimension
from rocs_bt.catalog import ActorSpec
from rocs_bt.check import check_content
from rocs_bt.compare import Floor, Post, load_family, walls_around
from rocs_bt.declare import fields_of
from rocs_bt.devices.mujoco import MujocoWorld, compose_world
from rocs_bt.event import NullSink
from rocs_bt.simulation import SCRIPTED_OBJECTS, build_world
from rocs_bt.simulation.scripts import object_script

PERIOD = 0.05
GROUND = Floor(
    (0.0, 0.0),
    (10.0, 8.0),
    [*walls_around((0.0, 0.0), (10.0, 8.0)), Post("pillar", 5.0, 4.0, 0.3)],
    [Post("P1", 2.0, 4.0, 0.25, 1.7), Post("P2", 8.0, 4.1, 0.25, 1.7)],
)


@pytest.fixture
def world(tmp_path: Path) -> MujocoWorld:
    file = tmp_path / "hall.xml"
    file.write_text(GROUND.world("hall", "A hall."))
    return compose_world(file, [])


def carried(world: MujocoWorld, script: str, name: str = "P1", seed: int = 1, **parameters: Any) -> Any:
    start = Pose2(2.0, 4.0) if name == "P1" else Pose2(8.0, 4.1)
    rng = np.random.default_rng(seed)
    script_class = SCRIPTED_OBJECTS.get(script)
    declared = fields_of(script_class) if script_class else ()
    units = {each.name: str(each.mark(Dimension)) for each in declared if each.mark(Dimension)}
    given = {k: f"{v} {units[k]}" if k in units and isinstance(v, (int, float)) else v for k, v in parameters.items()}
    actor = ActorSpec(name=name, script=script, pose=start, jitter=start, parameters=given)
    made = object_script(actor, type)
    made.bind(name, world, start, rng, PERIOD)
    return made


def track(world: MujocoWorld, *carriers: Any, seconds: float) -> Any:
    """(periods, carriers, 2) Where things are after each control period [m]."""
    found = []
    for i in range(round(seconds / PERIOD)):
        for carrier in carriers:
            carrier.step(i * PERIOD)
        world.advance(10)
        poses = [world.object_pose(carrier.name) for carrier in carriers]
        found.append([(pose.x, pose.y) for pose in poses])
    return np.array(found)


def test_a_door_slides_at_its_time_and_back(world: MujocoWorld) -> None:
    door = carried(world, "slide", to_x=3.0, to_y=4.0, depart_at=1.0, duration=0.5, return_at=3.0)
    way = track(world, door, seconds=4.0)[:, 0]
    times = PERIOD * np.arange(1, len(way) + 1)
    wanted = 2.0 + np.clip((times - 1.0) / 0.5, 0.0, 1.0) - np.clip((times - 3.0) / 0.5, 0.0, 1.0)
    assert way[:, 0] == pytest.approx(wanted, abs=1e-9)
    assert way[:, 1] == pytest.approx(4.0)


def test_a_polynomial_is_as_fast_everywhere_and_stays_within_its_bend(world: MujocoWorld) -> None:
    walk = carried(world, "polynomial", to_x=2.0, to_y=1.0, speed=0.8, deviation=0.5, order=4)
    way = track(world, walk, seconds=20.0)[:, 0]
    speeds = np.hypot(*np.diff(way, axis=0).T) / PERIOD
    assert np.median(speeds) == pytest.approx(0.8, rel=0.01)
    assert (speeds < 0.81).all()
    assert np.abs(way[:, 0] - 2.0).max() <= 0.5 + 1e-6
    assert way[:, 1].min() == pytest.approx(1.0, abs=0.05)
    assert way[:, 1].max() == pytest.approx(4.0, abs=0.05)
    other = carried(world, "polynomial", seed=2, to_x=2.0, to_y=1.0, speed=0.8, deviation=0.5, order=4)
    assert not np.allclose(track(world, other, seconds=1.0), way[:20, None])


def test_people_make_way_for_each_other_and_for_walls(world: MujocoWorld) -> None:
    one = carried(world, "social_force", to_x=8.0, to_y=4.1, speed=1.2)
    other = carried(world, "social_force", "P2", seed=2, to_x=2.0, to_y=4.0, speed=1.2)
    way = track(world, one, other, seconds=40.0)
    apart = np.hypot(*(way[:, 0] - way[:, 1]).T)
    assert apart.min() > 0.45  # two bodies of 0.25 m hardly touch
    assert np.hypot(*(way - (5.0, 4.0)).reshape(-1, 2).T).min() > 0.5  # nor the pillar, which is straight between
    assert way.min() > 0.2
    assert (way[..., 0] > 7.0).any(axis=0).all()
    assert (way[..., 0] < 3.0).any(axis=0).all()
    speeds = np.hypot(*np.moveaxis(np.diff(way, axis=0), 2, 0)) / PERIOD
    assert speeds.max() < 1.2 * 1.2 * 1.3 + 1e-6


def test_a_step_goes_no_farther_in_one_jump_than_a_physics_step(world: MujocoWorld) -> None:
    walk = carried(world, "polynomial", to_x=8.0, to_y=1.0, speed=1.0)
    walk.step(0.0)
    before = world.object_pose("P1")
    world.advance(1)
    assert world.object_pose("P1").distance(before) == pytest.approx(0.005, rel=0.05)


def test_a_thing_must_be_in_the_world(world: MujocoWorld) -> None:
    with pytest.raises(UnknownName, match=r"no mocap body is named 'P9'.*P1, P2"):
        world.place_object("P9", Pose2(0.0, 0.0))


def hall(tmp_path: Path, *actors: dict[str, object], x: str = "1 m") -> Catalog:
    folder = tmp_path / "scenarios"
    (folder / "worlds").mkdir(parents=True)
    (folder / "worlds" / "hall.xml").write_text(GROUND.world("hall", "A hall for a test of carried things."))
    root = {"format": "scenario/2", "doc": "A test.", "world": "hall", "duration": "8 s", "end_on_collision": False}
    agent = {"name": "R", "robot": "jackal", "mission": "go_to", "x": x, "y": "2 m", "parameters": {"goal": "goal"}}
    goal = {"name": "goal", "x": "8 m", "y": "2 m"}
    (folder / "hall.toml").write_text(as_toml(root | {"place": [goal], "agent": [agent], "actor": [*actors]}))
    return Catalog(tmp_path)


def test_a_robot_sees_a_thing_come_and_is_told_to_have_run_into_it(tmp_path: Path) -> None:
    box = {"name": "P1", "script": "slide", "x": "4 m", "y": "5 m", "to_x": "4 m", "to_y": "2 m", "depart_at": "1 s"}
    catalog = hall(tmp_path, box)
    assert not check_content([tmp_path]).has_errors
    summary, again = (run("hall", catalog, seed=1, report=False).summary for _ in range(2))
    assert summary.agents["R"].outcome == "collision"
    assert "P1" in summary.agents["R"].reason
    assert again.trajectory_hash == summary.trajectory_hash


def sliders(**more: str) -> list[dict[str, object]]:
    to = {"to_y": "6 m", "depart_at": "0 s", "script": "slide", **more}
    return [{"name": name, "x": x, "y": "5 m", "to_x": x, **to} for name, x in (("P1", "3 m"), ("P2", "7 m"))]


def test_of_a_group_the_seed_selects_the_one_that_follows_its_script(tmp_path: Path) -> None:
    catalog = hall(tmp_path, *sliders(one_of="doors"))
    assert not check_content([tmp_path]).has_errors
    moved = []
    for seed in (*range(1, 13), 1):
        simulated = build_world(catalog.load_scenario("hall"), catalog, seed, NullSink())
        for i in range(30):
            for actor in simulated.actors:
                actor.step(i * PERIOD)
            simulated.world.advance(10)
        moved.append([name for name in ("P1", "P2") if simulated.world.object_pose(name).y > 5.9])
        assert sorted(simulated.world.object_pose(name).y for name in ("P1", "P2")) == pytest.approx([5.0, 6.0])
    assert {len(names) for names in moved} == {1}
    assert {names[0] for names in moved} == {"P1", "P2"}
    assert moved[-1] == moved[0]


def test_a_robot_belongs_to_no_group(tmp_path: Path) -> None:
    robot = {"name": "M", "robot": "pioneer_p3dx", "script": "random_walk", "x": "5 m", "y": "6 m", "one_of": "robots"}
    with pytest.raises(InputError, match="one_of is for objects of the world") as caught:
        hall(tmp_path, robot).load_scenario("hall")
    assert caught.value.faults[0].line > 0


def test_nobody_starts_inside_of_a_thing(tmp_path: Path) -> None:
    person = {"name": "P1", "script": "polynomial", "x": "1 m", "y": "2 m", "to_x": "1.1 m", "to_y": "2 m"}
    with pytest.raises(InputError, match="inside 'P1'"):
        run("hall", hall(tmp_path, person), seed=1, report=False)


def test_a_crowd_runs_the_same_twice_and_another_seed_walks_otherwise(tmp_path: Path) -> None:
    scene = load_family(Catalog(), "crowd", {"density": "sparse"}).scene(2)
    scene.write(tmp_path)
    catalog = Catalog(tmp_path)
    first, same, other = (run(scene.name, catalog, seed=seed, duration=3.0, report=False).summary for seed in (1, 1, 2))
    assert first.trajectory_hash == same.trajectory_hash
    assert first.trajectory_hash != other.trajectory_hash
    assert math.isfinite(first.agents["R"].min_clearance)
