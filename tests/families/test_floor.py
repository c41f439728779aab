"""The floor: its grid against geometry, and its shortest way against networkx and plane geometry."""

from __future__ import annotations

import math

import networkx as nx
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.compare import Block, Floor, Post, length_of, shortest_cells

CELLS = st.integers(3, 9)


@settings(max_examples=60, deadline=None)
@given(st.data(), CELLS, CELLS)
def test_the_search_finds_what_networkx_finds(data: st.DataObject, rows: int, columns: int) -> None:
    free = np.array(
        data.draw(st.lists(st.lists(st.booleans(), min_size=columns, max_size=columns), min_size=rows, max_size=rows))
    )
    free[0, 0] = free[-1, -1] = True
    graph = nx.Graph()
    graph.add_nodes_from(map(tuple, np.argwhere(free).tolist()))
    for r, c in list(graph):
        for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
            if (other := (r + down, c + right)) in graph:
                graph.add_edge((r, c), other, weight=0.5 * math.hypot(down, right))
    found = shortest_cells(free, (0, 0), (rows - 1, columns - 1), 0.5)
    if not nx.has_path(graph, (0, 0), (rows - 1, columns - 1)):
        assert found is None
        return
    assert found is not None
    assert (found[0], found[-1]) == ((0, 0), (rows - 1, columns - 1))
    assert all(free[cell] for cell in found)
    wanted = nx.dijkstra_path_length(graph, (0, 0), (rows - 1, columns - 1))
    assert length_of([(0.5 * c, 0.5 * r) for r, c in found]) == pytest.approx(wanted)


def test_a_way_goes_straight_where_it_can_and_around_what_is_there() -> None:
    floor = Floor((0.0, 0.0), (6.0, 4.0))
    way = floor.grid(0.05).shortest((1.0, 1.0), (5.0, 3.0), 0.25)
    assert way is not None
    assert way.length == pytest.approx(math.hypot(4.0, 2.0))
    assert way.clearance == math.inf
    floor.obstacles.append(Block("wall", 3.0, 1.0, 0.2, 2.0))
    around = floor.grid(0.05).shortest((1.0, 1.0), (5.0, 1.0), 0.25)
    assert around is not None
    # Tangents to two circles of 0.25 m around the corners at (2.9, 2) and (3.1, 2).
    leg = math.sqrt(1.9**2 + 1.0**2 - 0.25**2)
    turn = (
        math.pi / 2.0 - (math.atan2(1.0, 1.9) + math.acos(0.25 / math.hypot(1.9, 1.0)) - math.pi / 2.0) - math.pi / 2.0
    )
    best = 2.0 * leg + 0.2 + 2.0 * 0.25 * max(turn, 0.0)
    assert best - 0.06 <= around.length <= best * 1.06 + 0.15
    assert floor.clearance(around.points) == math.inf
    floor.obstacles.append(Block("more", 3.0, 3.0, 0.2, 2.0))
    assert floor.grid(0.05).shortest((1.0, 1.0), (5.0, 1.0), 0.25) is None


@settings(max_examples=60, deadline=None)
@given(st.floats(0.5, 2.5), st.floats(0.5, 2.5), st.floats(0.1, 0.9), st.floats(0.1, 0.9), st.floats(-3.1, 3.1))
def test_the_grid_is_taken_where_things_are(x: float, y: float, length: float, width: float, yaw: float) -> None:
    grid = Floor((0.0, 0.0), (3.0, 3.0), [Block("b", x, y, length, width, yaw), Post("p", y, x, length / 2.0)]).grid(
        0.1
    )
    for row, column in np.ndindex(grid.occupied.shape):
        cx, cy = grid.centre(row, column)
        dx, dy = cx - x, cy - y
        along, aside = dx * math.cos(yaw) + dy * math.sin(yaw), dy * math.cos(yaw) - dx * math.sin(yaw)
        depth = max(abs(along) - length / 2.0, abs(aside) - width / 2.0)
        depth = min(depth, math.hypot(cx - y, cy - x) - length / 2.0)
        if abs(depth) > 1e-9:
            assert grid.occupied[row, column] == (depth < 0.0)


def test_clearance_is_to_the_surface_of_the_nearest_post() -> None:
    floor = Floor((0.0, -1.0), (4.0, 2.0), [Post("a", 1.0, 1.0, 0.1), Post("b", 3.0, -0.5, 0.2)])
    assert floor.clearance([(0.0, 0.0), (4.0, 0.0)]) == pytest.approx(0.3, abs=1e-3)
