"""Families in which people walk: nobody begins in another's place, and all stay in the hall."""

from __future__ import annotations

import itertools
import math
import re

import numpy as np
import pytest

from rocs_bt import Catalog
from rocs_bt.base.errors import InputError
from rocs_bt.compare import Post, TrafficFamily, load_family
from rocs_bt.event import ListSink
from rocs_bt.simulation import build_world

CATALOG = Catalog()
MOTIONS = ("polite", "mixed", "blind")
KINDS = [
    *(("crowd", {"motion": motion, "density": density}) for motion in MOTIONS for density in ("sparse", "dense")),
    *(("crossing", {"motion": motion}) for motion in MOTIONS),
    *(("corridor", {"motion": m, "encounter": e}) for m in MOTIONS for e in ("oncoming", "overtaking", "door")),
    *(("dynabarn", {"level": level}) for level in ("easy", "medium", "hard")),
]
FAMILIES = ("crowd", "crossing", "corridor", "dynabarn")
NAMES = ["-".join([name, *values.values()]) for name, values in KINDS]


def made(name: str, values: dict[str, object]) -> TrafficFamily:
    family = load_family(CATALOG, name, values)
    assert isinstance(family, TrafficFamily)
    return family


@pytest.mark.parametrize(("name", "values"), KINDS, ids=NAMES)
@pytest.mark.parametrize("middle", [0, 1])
def test_nobody_begins_in_the_place_of_another(name: str, values: dict[str, object], middle: int) -> None:
    family = made(name, values | {"middle": middle})
    for index in range(5):
        scene = family.scene(index)
        discs = [body for body in [*scene.floor.obstacles, *scene.floor.actors] if isinstance(body, Post)]
        for one, two in itertools.combinations(discs, 2):
            assert math.dist((one.x, one.y), (two.x, two.y)) > one.radius + two.radius
        x, y = scene.reference[0]
        assert min(math.dist((x, y), (disc.x, disc.y)) - disc.radius for disc in discs) > 0.6
        walking = [body for body in scene.floor.actors if isinstance(body, Post)]
        assert min(math.dist((x, y), (one.x, one.y)) - one.radius for one in walking) >= 1.5, "as docs/families.md says"
        assert (x == 1.0) != bool(middle)
        assert scene.reference_length > 0.25 * family.long
        assert scene.difficulty["people"] == len(scene.scenario["actor"])
        assert scene.difficulty["density"] == pytest.approx(len(scene.floor.actors) / (family.long * family.wide))


@pytest.mark.parametrize(("name", "values"), KINDS, ids=NAMES)
def test_all_walk_and_stay_between_the_walls(name: str, values: dict[str, object]) -> None:
    family = made(name, values)
    scene = family.scene(0)
    catalog = scene.added_to(CATALOG)
    simulated = build_world(catalog.load_scenario(scene.name), catalog, 1, ListSink())
    world, places = simulated.world, []
    for period in range(120):
        for actor in simulated.actors:
            actor.step(0.05 * period)
        world.advance(10)
        places.append([world.object_pose(body.name)[:2] for body in scene.floor.actors])
    way = np.array(places)
    assert world.contacts() == []
    assert (np.ptp(way, axis=0).max(axis=1) > 0.25).all(), "they walk"
    radius = min(body.radius for body in scene.floor.actors if isinstance(body, Post))
    assert min(world.room(*place) for place in way[::6].reshape(-1, 2)) > radius, "they walk through nothing"


def test_people_with_legs_step_in_turn_and_are_seen_by_their_legs_only() -> None:
    scene = made("crossing", {"motion": "blind", "legs": 1, "people": 2}).scene(0)
    assert scene.difficulty["people"] == 2.0
    catalog = scene.added_to(CATALOG)
    simulated = build_world(catalog.load_scenario(scene.name), catalog, 1, ListSink())
    world, places = simulated.world, []
    for period in range(100):
        for actor in simulated.actors:
            actor.step(0.05 * period)
        world.advance(10)
        places.append([world.object_pose(f"P0{part}")[:2] for part in ("", "_left", "_right")])
    way = np.array(places)
    speeds = np.hypot(*np.moveaxis(np.diff(way, axis=0), 2, 0))[10:] / 0.05
    rests = speeds[:, 1:] < 0.3 * np.median(speeds[:, 0])
    assert (rests.mean(axis=0) > 0.3).all()
    assert (rests.mean(axis=0) < 0.7).all()
    assert rests.all(axis=1).mean() < 0.1, "one of them steps"
    assert speeds.max() < 2.6 * speeds[:, 0].max()
    apart = np.hypot(*np.moveaxis(way[:, 1:] - way[:, :1], 2, 0))
    assert 0.05 < apart.min() < apart.max() < 0.4
    near = {near.name for near in world.around("R", 20.0)}
    assert near == {"P0", "P1"}, "people and robots keep away from the person"
    pose = world.pose("R")
    bearings = pose.yaw + np.radians(np.linspace(-135.0, 135.0, 720))
    ranges = np.array(simulated.sensors["R"]["lidar"].read().values)
    scanner = np.array(pose[:2]) + 0.12 * np.array([math.cos(pose.yaw), math.sin(pose.yaw)])
    echoes = scanner + ranges[:, None] * np.stack([np.cos(bearings), np.sin(bearings)], axis=1)
    body, *legs = (np.hypot(*(echoes - place).T) for place in way[-1])
    seen = body < 0.45
    assert 2 <= seen.sum() < 20
    assert np.min(legs, axis=0)[seen].max() < 0.12, "echoes of the legs only"


def test_the_densities_of_a_crowd_are_these() -> None:
    scenes = [made("crowd", {"density": density}).scene(1) for density in ("sparse", "normal", "dense")]
    assert [scene.difficulty["people"] for scene in scenes] == [4, 8, 14]
    assert made("crowd", {}).parameters["density"] == "normal"


def test_people_are_polite_blind_or_both_in_turn() -> None:
    for motion, scripts in zip(
        MOTIONS, (["social_force"], ["social_force", "polynomial"], ["polynomial"]), strict=True
    ):
        actors = made("crowd", {"motion": motion}).scene(2).scenario["actor"]
        assert [actor["script"] for actor in actors] == [scripts[i % len(scripts)] for i in range(8)]


@pytest.mark.parametrize("name", FAMILIES)
def test_a_hall_of_any_size_has_a_scene_or_says_why_not(name: str) -> None:
    for long, wide in itertools.product((0.5, 5.0, 6.0, 8.0), (0.5, 2.0, 3.0, 4.0)):
        try:
            made(name, {"long": f"{long} m", "wide": f"{wide} m"}).scene(0)
        except InputError as error:
            found = str(error)
            assert re.search(r"must be at least|has no room for|has no path for a robot", found), found


def test_a_hall_that_is_too_small_is_refused() -> None:
    with pytest.raises(InputError, match="no room for 40 people"):
        made("corridor", {"people": 40}).scene(0)


@pytest.mark.parametrize("family", ["crowd", "dynabarn"])
def test_a_hall_without_room_is_refused_and_never_tried_for_ever(family):
    with pytest.raises(InputError, match=r"has no room for .*; make the hall larger"):
        load_family(Catalog(), family, {"long": "7 m" if family == "crowd" else "6 m", "wide": "4 m"}).scene(0)
