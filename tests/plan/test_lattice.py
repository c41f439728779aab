"""The route planner `lattice`: its ways leave room for the hull as it stands there."""

import math
from itertools import pairwise

import numpy as np
import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.clock import SimulatedClock
from rocs_bt.event import NullSink
from rocs_bt.geometry import Pose2
from rocs_bt.knowledge import Knowledge, OccupancyGrid
from rocs_bt.plan import NoRoute

PLANNER = Catalog().load_route("lattice")
START, GOAL = Pose2(0.0, 0.0, 0.0), Pose2(4.0, 0.0, 0.0)


def knowing(*points, length=0.5, width=0.4):
    knowledge = Knowledge("R1", SimulatedClock(0.05), NullSink())
    knowledge.graph.set("R1", length=length, width=width)
    knowledge.world.occupancy = grid = OccupancyGrid(0.05, 30.0)
    for _ in range(3):
        grid.add_scan(np.array(points, float).reshape(-1, 2), np.empty((0, 2), np.intp))
    return knowledge


def wall(x, low, high):
    return [(x, y) for y in np.arange(low, high, 0.04)]


def route(knowledge, start=START, goal=GOAL, clearance=0.05):
    return PLANNER(knowledge).route(start, goal, clearance)


def length(way):
    return sum(math.dist(a, b) for a, b in pairwise(way))


def nearest(way, points):
    line = np.vstack([np.linspace(a, b, 40) for a, b in pairwise(way)])
    return np.hypot(*(line[:, None] - np.array(points)).transpose(2, 0, 1)).min()


def test_where_nothing_is_it_is_hardly_longer_than_straight():
    way = route(knowing())
    assert (way[0], way[-1]) == ((0.0, 0.0), (4.0, 0.0))
    assert length(way) < 4.3


def test_it_goes_round_a_wall_with_room_for_the_hull():
    things = wall(2.0, -3.0, 1.0)
    way = route(knowing(*things))
    assert max(y for _, y in way) > 1.2
    assert nearest(way, things) > 0.2


def test_a_gap_is_taken_if_the_hull_fits_and_gone_round_if_not():
    for gap, through in ((1.0, True), (0.5, False)):
        things = wall(2.0, -3.0, -0.5 * gap) + wall(2.0, 0.5 * gap, 1.5)
        way = route(knowing(*things))
        assert (max(abs(y) for _, y in way) < 0.6) is through


def test_behind_it_it_turns():
    way = route(knowing(), start=Pose2(0.0, 0.0, math.pi))
    assert length(way) < 6.0
    assert way[-1] == (4.0, 0.0)


def test_a_goal_that_is_walled_in_has_no_way():
    ring = [(4.0 + math.cos(a), math.sin(a)) for a in np.linspace(0.0, 2.0 * math.pi, 200)]
    with pytest.raises(NoRoute, match="contains no path"):
        route(knowing(*ring))


def test_a_way_is_kept_until_something_stands_on_it():
    knowledge = knowing(*wall(2.0, -3.0, 1.0))
    planner = PLANNER(knowledge)
    first = planner.route(START, GOAL, 0.05)
    assert planner.route(Pose2(*first[1], 0.0), GOAL, 0.05) is first
    far = np.array([(3.0, -3.0)])
    knowledge.world.occupancy.add_scan(far, np.empty((0, 2), np.intp))
    assert planner.route(Pose2(*first[1], 0.0), GOAL, 0.05) is first
    middle = first[len(first) // 2]
    for _ in range(3):
        knowledge.world.occupancy.add_scan(np.array([middle]), np.empty((0, 2), np.intp))
    assert planner.route(Pose2(*first[1], 0.0), GOAL, 0.05) is not first


def test_far_goals_are_led_towards():
    way = route(knowing(), goal=Pose2(40.0, 3.0, 0.0))
    assert way[-1][0] > 6.0
