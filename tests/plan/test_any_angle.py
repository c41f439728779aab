"""The route planner `any_angle`: its ways are free, and hardly longer than the shortest there is."""

import math
from itertools import pairwise

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.compare import length_of
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge, OccupancyGrid
from rocs_bt.plan import NoRoute

PLANNER = Catalog().load_route("any_angle")
CELL = 0.1


def knowing(occupied, **body):
    """A robot whose map has these cells (row, column) occupied."""
    knowledge = Knowledge("R1", SimulatedClock(0.05), NullSink())
    knowledge.graph.set("R1", **body)
    knowledge.world.occupancy = grid = OccupancyGrid(CELL, 30.0)
    cells = np.array(sorted(occupied), np.intp).reshape(-1, 2)
    for _ in range(3):
        grid.add_scan(grid.centres(cells), np.empty((0, 2), np.intp))
    return knowledge


def middle(cell):
    return (cell[1] + 0.5) * CELL, (cell[0] + 0.5) * CELL


def route(knowledge, start, goal, clearance=0.0):
    return PLANNER(knowledge).route(Pose2(*start, 0.0), Pose2(*goal, 0.0), clearance)


def test_round_a_wall_it_turns_at_its_end():
    knowledge = knowing([(row, 10) for row in range(-20, 11)], length=0.4, width=0.4)
    path = route(knowledge, (0.05, 0.05), (2.05, 0.05), clearance=0.1)
    assert 3 <= len(path) <= 6
    end = np.array([1.05, 1.05])  # the middle of the wall's last cell
    nearest = min(np.hypot(*(np.linspace(a, b, 50) - end).T).min() for a, b in pairwise(path))
    assert 0.3 - 0.5 * CELL < nearest < 0.3 + 1.5 * CELL


def test_without_a_map_it_says_what_to_do():
    with pytest.raises(NoRoute, match="add the analyser LocalMap"):
        route(Knowledge("R1", SimulatedClock(0.05), NullSink()), (0.0, 0.0), (1.0, 0.0))


def on_the_grid(occupied, start, goal, size):
    """The length of the shortest way over eight neighbours that cuts no corner; infinite without one."""
    graph = nx.Graph()
    free = {(r, c) for r in range(-2, size + 2) for c in range(-2, size + 2)} - set(occupied)
    for r, c in free:
        for i, j in ((0, 1), (1, 0), (1, 1), (1, -1)):
            if {(r + i, c + j), (r + i, c), (r, c + j)} <= free:
                graph.add_edge((r, c), (r + i, c + j), weight=CELL * math.hypot(i, j))
    try:
        return nx.shortest_path_length(graph, start, goal, weight="weight")
    except (nx.NetworkXNoPath, nx.NodeNotFound):
        return math.inf


@settings(max_examples=60, deadline=None)
@given(st.sets(st.tuples(st.integers(0, 9), st.integers(0, 9)), max_size=40))
def test_it_is_free_and_no_longer_than_the_way_over_the_grid(occupied):
    start, goal = (0, 0), (9, 9)
    occupied -= {start, goal}
    # A fence around, so that nobody gets around what the oracle looks at.
    fence = {(r, c) for r in range(-3, 13) for c in range(-3, 13) if r in (-3, 12) or c in (-3, 12)}
    shortest = on_the_grid(occupied, start, goal, 10)
    knowledge = knowing(occupied | fence)
    if shortest == math.inf:
        with pytest.raises(NoRoute):
            route(knowledge, middle(start), middle(goal))
        return
    path = route(knowledge, middle(start), middle(goal))
    assert length_of(path) <= shortest + 1e-9
    assert length_of(path) >= math.dist(middle(start), middle(goal)) - 1e-9
    for a, b in pairwise(path):
        for x, y in np.linspace(a, b, 200):
            assert (math.floor(y / CELL + 1e-9), math.floor(x / CELL + 1e-9)) not in occupied or _on_border(x, y)


def _on_border(x, y):
    """A line along the border between two cells is in neither."""
    return any(abs(v / CELL - round(v / CELL)) < 1e-6 for v in (x, y))
