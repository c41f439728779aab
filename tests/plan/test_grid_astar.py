"""GridAstar: its search against networkx on the same graph, and the ways that it draws."""

import itertools
import math

import networkx as nx
import numpy as np
import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.control.elastic_band import DistanceField
from rocs_bt.control.footprint import Footprint
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge, OccupancyGrid
from rocs_bt.plan import NoRoute

PLANNER = Catalog.here().load_route("grid_astar")
MODULE = PLANNER.search.__globals__
HULL = Footprint(0.5, 0.4)
START, GOAL = Pose2(0.0, 0.0), Pose2(5.0, 0.0)


def post(x, y, radius=0.1):
    angles = np.linspace(0.0, math.tau, 40)
    return np.column_stack([x + radius * np.cos(angles), y + radius * np.sin(angles)])


class Bench:
    def __init__(self, *things):
        self.clock = SimulatedClock(0.05)
        self.knowledge = Knowledge("R", self.clock, NullSink())
        self.knowledge.graph.set("R", length=HULL.length, width=HULL.width)
        self.grid = self.knowledge.world.occupancy = OccupancyGrid(0.05, 30.0)
        self.planner = PLANNER(self.knowledge)
        self.see(*things)

    def see(self, *things):
        for thing in things:
            self.grid.add_scan(thing, np.empty((0, 2), dtype=np.intp))
        for _ in range(5):
            self.clock.advance()

    def route(self, start=START, goal=GOAL, clearance=0.02):
        return self.planner.route(start, goal, clearance)

    def gaps(self, way):
        points = np.array(way)
        chord = np.gradient(points, axis=0)
        poses = np.column_stack([points, np.arctan2(chord[:, 1], chord[:, 0])])
        return HULL.clearance(poses, self.grid.window((-9.0, -9.0), (9.0, 9.0)).points())


def dijkstra(cost, start, goal):
    graph = nx.Graph()
    for cell in np.ndindex(cost.shape):
        for step in ((0, 1), (1, 0), (1, 1), (1, -1)):
            other = (cell[0] + step[0], cell[1] + step[1])
            if 0 <= other[0] < cost.shape[0] and 0 <= other[1] < cost.shape[1]:
                weight = 0.5 * math.hypot(*step) * (cost[cell] + cost[other])
                if weight < math.inf:
                    graph.add_edge(cell, other, weight=weight)
    there = {start, goal} <= set(graph) and nx.has_path(graph, start, goal)
    return nx.dijkstra_path_length(graph, start, goal) if there else math.inf


@pytest.mark.parametrize("closed", ["neither", "start", "goal", "both"])
@pytest.mark.parametrize("seed", range(20))
def test_the_search_finds_a_cheapest_way_as_networkx_does_also_from_and_to_closed_cells(seed, closed):
    rng = np.random.default_rng(seed)
    shape = tuple(rng.integers(8, 30, 2))
    cost = 1.0 + rng.exponential(2.0, shape)
    cost[rng.random(shape) < rng.choice([0.0, 0.2, 0.45])] = math.inf
    start, goal = (0, int(rng.integers(shape[1]))), (shape[0] - 1, int(rng.integers(shape[1])))
    cost[start] = math.inf if closed in ("start", "both") else 1.0
    cost[goal] = math.inf if closed in ("goal", "both") else 1.0
    field = MODULE["Field"](DistanceField(0.0, 0.0, 1.0, cost, np.empty((0, 2))), cost, 0.2, 0)
    found = MODULE["_search"](field, cost, (start[1] + 0.5, start[0] + 0.5), (goal[1] + 0.5, goal[0] + 0.5))
    expected = dijkstra(cost, start, goal)
    if found is None:
        assert expected == math.inf
        return
    cells = [(int(y), int(x)) for x, y in found]
    assert (cells[0], cells[-1]) == (start, goal)
    paid = sum(0.5 * math.dist(a, b) * (cost[a] + cost[b]) for a, b in itertools.pairwise(cells))
    assert paid == pytest.approx(expected, rel=1e-6)


def test_it_goes_through_the_middle_of_a_gap_that_just_fits():
    gap = 0.25  # from the middle to either side: 5 cm beside the hull
    bench = Bench(*(post(2.5, sign * (gap + 0.1 + 0.2 * k)) for sign in (-1, 1) for k in range(20)))
    way = bench.route()
    assert bench.gaps(way).min() >= 0.02
    assert min(math.dist(p, (2.5, 0.0)) for p in way) < 0.1


def test_a_gap_that_is_too_narrow_is_gone_round_and_where_there_is_no_other_there_is_no_way():
    narrow = [post(2.5, sign * (0.19 + 0.1 + 0.15 * k)) for sign in (-1, 1) for k in range(8)]
    bench = Bench(*narrow)
    way = np.array(bench.route())
    assert np.abs(way[:, 1]).max() > 1.0
    ring = [post(5.0 + 1.2 * math.cos(a), 1.2 * math.sin(a)) for a in np.linspace(0.0, math.tau, 60)]
    with pytest.raises(NoRoute, match="contains no path"):
        Bench(*ring).route()


def test_a_way_is_kept_to_the_object_until_something_new_stands_in_it():
    bench = Bench(post(2.5, 1.5))
    way = bench.route()
    bench.see(post(2.5, 3.0))
    assert bench.route(Pose2(0.3, 0.0)) is way
    bench.see(post(2.5, 0.0))
    new = bench.route(Pose2(0.3, 0.0))
    assert new is not way
    assert bench.gaps(new).min() > 0.02


def test_a_robot_that_stands_too_near_to_something_may_drive_off():
    bench = Bench(post(0.0, 0.32))
    assert bench.route()[-1] == pytest.approx((5.0, 0.0))


def test_a_far_goal_is_approached_through_what_the_window_holds():
    way = Bench().route(goal=Pose2(20.0, 3.0))
    assert 6.0 < way[-1][0] < 9.0


def test_without_a_map_it_says_what_is_missing():
    bench = Bench()
    bench.knowledge.world.occupancy = None
    with pytest.raises(NoRoute, match="LocalMap"):
        bench.route()


def test_a_way_is_bent_by_what_comes_up_beside_it_but_for_what_is_driven_already():
    bench = Bench()
    way = bench.route()
    bench.see(post(2.5, 0.36))  # 6 cm beside the hull, where there is room on the other side
    bent = bench.route(Pose2(0.3, 0.0))
    assert bench.gaps(way).min() < 0.1
    assert bench.gaps(bent).min() > 0.14
    assert np.array(bent)[:2] == pytest.approx(np.array(way)[2:4])  # from behind the robot on
    assert bent[-1] == way[-1]
    assert bench.route(Pose2(0.3, 0.0)) is bent


@pytest.mark.parametrize("moving", [True, False])
def test_a_way_leads_around_what_moves_only_if_the_follower_does_not(moving):
    bench, beside = Bench(post(2.5, 3.0)), np.empty((0, 2), dtype=np.intp)
    bench.planner.moving = moving
    way = bench.route()
    for x in (2.0, 2.1):
        bench.grid.add_scan(np.empty((0, 2)), beside, None, post(x, 0.1))
        for _ in range(5):
            bench.clock.advance()
        assert (bench.route(Pose2(0.2, 0.0)) is way) is not moving
    assert bench.grid.still_revision < bench.grid.revision


@pytest.mark.parametrize(("yaw", "fits"), [(0.5, True), (0.0, False)])
def test_a_way_is_held_against_the_hull_as_the_robot_turns_into_it(yaw, fits):
    points = np.outer(np.arange(12) * 0.1, (math.cos(0.5), math.sin(0.5)))
    things = np.array([(0.31, -0.1)])  # beside the hull on its way, but before it while it looks to the right
    bench = Bench(things)
    field = MODULE["Field"].of(bench.grid.window((-1.0, -1.0), (2.0, 2.0)), HULL.inner)
    place = MODULE["_too_tight"](field, HULL, points, Pose2(0.0, 0.0, yaw), 0.02)
    assert (place is None) is fits
