"""A search without a path is short, and is not repeated while nothing has changed; for each planner in a map."""

import math

import numpy as np
import pytest
import scipy.ndimage

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.control.locomotion_kinds import make_locomotion
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge, OccupancyGrid
from rocs_bt.plan import MapRoutePlanner, NoRoute, Observation, Task

CATALOG = Catalog()
START, GOAL = Pose2(0.0, 0.0), Pose2(5.0, 0.0)
DRIVE = make_locomotion("differential", wheel_separation=0.3, max_wheel_speed=1.0, max_wheel_acceleration=1.0)
LENGTH, WIDTH, CLEARANCE = 0.5, 0.4, 0.02
ROUTES = {entry.name: CATALOG.load_route(entry.name) for entry in CATALOG.list("route")}
IN_A_MAP = sorted(name for name, cls in ROUTES.items() if issubclass(cls, MapRoutePlanner))


def ring(centre, radius):
    return [(centre.x + radius * math.cos(a), centre.y + radius * math.sin(a)) for a in np.linspace(0.0, math.tau, 400)]


def wall(gap):
    """From edge to edge of the map, with a gap."""
    return [(2.5, side * y) for side in (-1.0, 1.0) for y in np.arange(0.5 * gap, 14.0, 0.04)]


SCENES = {
    "start in a small ring": ring(START, 0.5),
    "start in a ring": ring(START, 1.2),
    "goal in a small ring": ring(GOAL, 0.5),
    "goal in a ring": ring(GOAL, 1.2),
    "gap too narrow for the hull": wall(0.42),
    "gap too narrow for the grid": wall(0.3),
}


@pytest.fixture
def transforms(monkeypatch):
    """Shapes of all distance transforms."""
    done, original = [], scipy.ndimage.distance_transform_edt

    def counted(cells, *args, **kwargs):
        done.append(cells.shape)
        return original(cells, *args, **kwargs)

    monkeypatch.setattr(scipy.ndimage, "distance_transform_edt", counted)
    for cls in ROUTES.values():
        space = cls.__dict__["search"].__globals__ if "search" in cls.__dict__ else {}
        if "distance_transform_edt" in space:
            monkeypatch.setitem(space, "distance_transform_edt", counted)
    return done


def knowing(points):
    knowledge = Knowledge("R", SimulatedClock(0.05), NullSink())
    knowledge.graph.set("R", length=LENGTH, width=WIDTH)
    knowledge.world.occupancy = OccupancyGrid(0.05, 30.0)
    see(knowledge, points)
    return knowledge


def see(knowledge, points):
    knowledge.world.occupancy.add_scan(np.array(points), np.empty((0, 2), dtype=np.intp))
    for _ in range(5):
        knowledge.clock.advance()


def refused(planner, start=START):
    with pytest.raises(NoRoute) as caught:
        planner.route(start, GOAL, CLEARANCE)
    return str(caught.value)


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("name", IN_A_MAP)
def test_a_search_without_a_path_is_short_and_not_repeated(name, scene, transforms):
    knowledge = knowing(SCENES[scene])
    planner = ROUTES[name](knowledge)
    reasons = {refused(planner, Pose2(0.004 * i, 0.0, 0.05 * i)) for i in range(5)}
    assert len(reasons) == 1
    assert len(transforms) <= 2
    transforms.clear()
    see(knowledge, [(-1.0, 3.0)])
    assert {refused(planner)} == reasons
    assert 1 <= len(transforms) <= 2
    transforms.clear()
    assert {refused(planner, Pose2(-0.1, 0.0))} == reasons
    assert 1 <= len(transforms) <= 2


@pytest.mark.parametrize("name", IN_A_MAP)
def test_a_path_that_opens_is_found(name):
    knowledge = knowing(wall(0.42))
    planner = ROUTES[name](knowledge)
    refused(planner)
    see(knowledge, [(-1.0, 3.0)])  # the wall is gone: what the newest scan sees is kept
    knowledge.world.occupancy.clear(2.5, 0.0, 2.0)
    assert len(planner.route(START, GOAL, CLEARANCE)) >= 2


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("name", ["dynamic_window", "mppi"])
def test_a_planner_that_follows_such_a_path_does_not_search_again_either(name, scene, transforms):
    knowledge, spec = knowing(SCENES[scene]), CATALOG.load_planner(name)
    cls = spec.mission.rpartition(":")[2]
    planner = CATALOG.load_class(CATALOG.find("mission", spec.mission).path, cls)()

    def routes(route):
        return ROUTES[route](knowledge)

    task = Task({"goal": GOAL}, {"goal": 0.1}, DRIVE, knowledge, route=routes)
    planner.reset(task, np.random.default_rng(1))
    for i in range(5):
        planner.act(Observation(0.1 * i, START, {}))
    assert len(transforms) <= 3  # one for the clearances of the arcs
