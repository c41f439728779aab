"""Ways over roads: the planners `dijkstra` and `astar`, roads and doors that close, and roads drawn on a map."""

import math
from itertools import pairwise, permutations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import KnowledgeError
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.event import NullSink
from rocs_bt.knowledge import FREE, OCCUPIED, Knowledge, Roadmap, Window, add_lattice_roads
from rocs_bt.plan import NoRoute

DIJKSTRA, ASTAR = (Catalog().load_route(name) for name in ("dijkstra", "astar"))
BOTH = pytest.mark.parametrize("planner", [DIJKSTRA, ASTAR], ids=["dijkstra", "astar"])


def knowing(places, roads=(), **body):
    """A robot that knows places by name, and roads as (from, to, attributes), both ways."""
    knowledge = Knowledge("R1", SimulatedClock(0.05), NullSink())
    knowledge.graph.set("R1", **body)
    for name, (x, y) in places.items():
        knowledge.world.place(name, Pose2(x, y, 0.0))
    for a, b, *more in roads:
        for source, target in ((a, b), (b, a)):
            knowledge.graph.relate(source, "connects", target, **(more[0] if more else {}))
    return knowledge


SQUARE = {"a": (0.0, 0.0), "b": (4.0, 0.0), "c": (4.0, 4.0), "d": (0.0, 4.0)}
RING = [("a", "b"), ("b", "c"), ("c", "d"), ("d", "a")]


def route(planner, knowledge, start=(0.0, 0.0), goal=(4.0, 4.0), clearance=0.0):
    return planner(knowledge).route(Pose2(*start, 0.0), Pose2(*goal, 0.0), clearance)


@BOTH
def test_an_edge_that_closes_is_gone_round_and_one_that_opens_is_used_again(planner):
    knowledge = knowing(SQUARE, RING)
    knowledge.graph.relate("a", "connects", "b", open=False)
    assert route(planner, knowledge) == [(0.0, 0.0), (0.0, 4.0), (4.0, 4.0)]
    knowledge.graph.relate("a", "connects", "d", open=False)
    with pytest.raises(NoRoute, match=r"no open road leads to the goal; closed: a-b \(closed\), a-d \(closed\)"):
        route(planner, knowledge)
    knowledge.graph.relate("a", "connects", "b", open=True)
    assert route(planner, knowledge) == [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0)]


@BOTH
def test_a_closed_door_shuts_the_road_both_ways_and_an_unknown_one_does_not(planner):
    knowledge = knowing(SQUARE, RING)
    knowledge.graph.add("door", "door")
    for place in ("a", "b"):
        knowledge.graph.relate("door", "leads_to", place)
    straight = route(planner, knowledge, goal=(4.0, 0.0))
    assert straight == [(0.0, 0.0), (4.0, 0.0)]
    knowledge.graph.set("door", open=False)
    assert len(route(planner, knowledge, goal=(4.0, 0.0))) == 4
    assert len(route(planner, knowledge, start=(4.0, 0.0), goal=(0.0, 0.0))) == 4
    assert "a-b (door is closed)" in Roadmap(knowledge).closed
    knowledge.graph.set("door", open=True)
    assert route(planner, knowledge, goal=(4.0, 0.0)) == straight


def test_a_road_that_is_too_narrow_is_left_out():
    knowledge = knowing(SQUARE, [("a", "b", {"width": 0.8}), *RING[1:]], width=0.5)
    assert len(route(ASTAR, knowledge, goal=(4.0, 0.0), clearance=0.1)) == 2
    assert len(route(ASTAR, knowledge, goal=(4.0, 0.0), clearance=0.2)) == 4


def test_one_who_stands_beside_a_road_joins_it_where_that_is_cheaper():
    knowledge = knowing(SQUARE, RING)
    assert route(ASTAR, knowledge, start=(3.0, 0.2)) == [(3.0, 0.2), (4.0, 0.0), (4.0, 4.0)]
    assert route(ASTAR, knowledge, start=(1.0, 0.2), goal=(0.1, 3.0))[:2] == [(1.0, 0.2), (0.0, 0.0)]


def test_nobody_is_led_onto_a_road_that_is_closed():
    knowledge = knowing(SQUARE, RING)
    for a, b in (("a", "b"), ("b", "a")):
        knowledge.graph.relate(a, "connects", b, open=False)
    with pytest.raises(NoRoute, match="no open road leads to the goal"):
        route(ASTAR, knowledge, start=(4.0, 4.0), goal=(2.0, 0.0))


def test_without_roads_it_says_what_to_do():
    with pytest.raises(NoRoute, match=r"relate places with 'connects', as \[\[road\]\] does"):
        route(ASTAR, knowing(SQUARE))


roads = st.lists(
    st.tuples(
        st.integers(0, 6),
        st.integers(0, 6),
        st.floats(1.0, 5.0),
        st.floats(0.25, 4.0),
        st.booleans(),
    ).filter(lambda r: r[0] != r[1]),
    min_size=1,
    max_size=16,
)


@settings(max_examples=120, deadline=None)
@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=7, max_size=7, unique=True), roads)
def test_both_find_what_brute_force_finds(spots, drawn):
    places = {f"p{i}": (float(x), float(y)) for i, (x, y) in enumerate(spots)}
    knowledge = knowing(places)
    cost = {}
    for a, b, longer, dear, is_open in drawn:
        length = longer * math.dist(places[f"p{a}"], places[f"p{b}"])
        knowledge.graph.relate(f"p{a}", "connects", f"p{b}", length=length, cost=dear, open=is_open)
        cost[f"p{a}", f"p{b}"] = length * dear if is_open else math.inf
    start, goal = places["p0"], places["p1"]
    chains = (["p0", *middle, "p1"] for n in range(6) for middle in permutations([f"p{i}" for i in range(2, 7)], n))
    best = min(sum(cost.get(edge, math.inf) for edge in pairwise(chain)) for chain in chains)
    used = {n for (a, b), c in cost.items() if c < math.inf for n in (a, b)}
    if not {"p0", "p1"} <= used:
        return  # nobody stands at an end of a road: how the roads are joined is another matter
    searches = [planner(knowledge).search for planner in (DIJKSTRA, ASTAR)]
    ways = [Roadmap(knowledge).route(start, goal, search) for search in searches]
    if best == math.inf:
        assert ways == [None, None]
        return
    assert [way.cost for way in ways] == pytest.approx([best, best])
    assert all(way.points[0] == start and way.points[-1] == goal for way in ways)


def test_a_way_is_the_same_until_something_changes():
    knowledge = knowing(SQUARE, RING)
    planner, goal = ASTAR(knowledge), Pose2(4.0, 4.0, 0.0)
    first = planner.route(Pose2(0.0, 0.0, 0.0), goal, 0.0)
    assert planner.route(Pose2(1.0, 0.2, 0.0), goal, 0.0) is first
    assert planner.route(Pose2(1.0, 0.9, 0.0), goal, 0.0) is not first
    first = planner.route(Pose2(1.0, 0.0, 0.0), goal, 0.0)
    knowledge.graph.relate("b", "connects", "c", open=False)
    second = planner.route(Pose2(1.0, 0.0, 0.0), goal, 0.0)
    assert second == [(1.0, 0.0), (0.0, 0.0), (0.0, 4.0), (4.0, 4.0)]
    knowledge.graph.add("somebody", "person")
    assert planner.route(Pose2(0.5, 0.0, 0.0), goal, 0.0) is second


def a_map(rows, cell=0.1):
    """A window of text: `#` is occupied, `?` unknown; the first row is the northernmost."""
    letters = {"#": OCCUPIED, "?": -1, ".": FREE}
    states = np.array([[letters[c] for c in row] for row in reversed(rows)], np.int8)
    return Window(states, np.zeros((*states.shape, 2)), 0.0, 0.0, cell, 1)


def test_roads_are_drawn_where_the_map_is_free():
    rows = ["#" * 42] + ["#" + "." * 40 + "#"] * 40 + ["#" * 42]
    wall = [row[:20] + "##" + row[22:] if i < 30 else row for i, row in enumerate(rows)]
    knowledge = knowing({})
    names = add_lattice_roads(knowledge, a_map(wall), spacing=0.5, clearance=0.2)
    poses = [knowledge.world.pose_of(name) for name in names]
    assert len(names) > 40
    assert all(0.3 < p.x < 3.9 and 0.3 < p.y < 3.9 for p in poses)
    assert not any(1.8 < p.x < 2.4 and p.y > 1.4 for p in poses)
    way = route(ASTAR, knowledge, start=(1.0, 3.0), goal=(3.2, 3.0))
    crossing = [y for (x0, y0), (x1, y1) in pairwise(way) for y in (y0, y1) if min(x0, x1) < 2.1 < max(x0, x1)]
    assert max(crossing) < 1.2  # round the wall, which ends 1.2 m above the floor


@settings(max_examples=60, deadline=None)
@given(st.lists(st.text("..........#?", min_size=16, max_size=16), min_size=16, max_size=16), st.floats(0.05, 0.3))
def test_no_road_comes_nearer_than_the_clearance(rows, clearance):
    knowledge, window = knowing({}), a_map(rows)
    add_lattice_roads(knowledge, window, spacing=0.3, clearance=clearance)
    blocked = np.argwhere(window.states != FREE)[:, ::-1] * window.cell + 0.5 * window.cell
    for a, _, b in knowledge.graph.edges("connects"):
        ends = [knowledge.world.pose_of(name)[:2] for name in (a, b)]
        for u in np.linspace(0.0, 1.0, 9):
            point = (1 - u) * np.array(ends[0]) + u * np.array(ends[1])
            if len(blocked):
                # The middle of the cell that the point is in keeps the clearance; the point is half a cell off at most.
                assert np.hypot(*(blocked - point).T).min() > clearance - 0.08


def test_a_lattice_finer_than_the_map_is_refused():
    with pytest.raises(KnowledgeError, match=r"spacing 0.05 m is less than a cell of 0.1 m"):
        add_lattice_roads(knowing({}), a_map(["..", ".."]), spacing=0.05, clearance=0.0)
