"""OccupancyGrid: evidence by cell, a mean echo in each, and a square that rolls along."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import KnowledgeError
from rocs_bt.base.geometry import Pose2, wrap_angle
from rocs_bt.knowledge import FREE, OCCUPIED, UNKNOWN, OccupancyGrid, View

NONE = np.empty((0, 2))
NO_CELLS = np.empty((0, 2), dtype=np.intp)


def seen(grid, *points, times=1):
    for _ in range(times):
        grid.add_scan(np.array(points), NO_CELLS)


def test_nothing_is_known_then_something_stands_there_then_it_is_gone():
    grid, place = OccupancyGrid(0.1, 4.0), np.array([[0.52, -0.31]])
    assert grid.state(0.52, -0.31) == UNKNOWN
    assert grid.add_scan(place, NO_CELLS) == 1
    assert grid.state(0.52, -0.31) == OCCUPIED
    looks = 0
    while grid.state(0.52, -0.31) != FREE:
        grid.add_scan(NONE, grid.cells(place))
        looks += 1
    assert 1 < looks < 10


def test_an_echo_outweighs_the_beams_that_pass_it_in_the_same_look():
    grid, place = OccupancyGrid(0.1, 4.0), np.array([[0.5, 0.5]])
    for _ in range(30):
        grid.add_scan(place, grid.cells(place))
    assert grid.state(0.5, 0.5) == OCCUPIED


def test_what_was_sure_for_long_goes_as_fast_as_what_was_sure_for_short():
    short, long, place = OccupancyGrid(0.1, 4.0), OccupancyGrid(0.1, 4.0), np.array([[0.5, 0.5]])
    seen(short, (0.5, 0.5), times=5)
    seen(long, (0.5, 0.5), times=500)
    for _ in range(12):
        short.add_scan(NONE, short.cells(place)), long.add_scan(NONE, long.cells(place))
    assert short.state(0.5, 0.5) == long.state(0.5, 0.5) == FREE


def test_echoes_are_averaged_within_their_cell():
    grid, rng = OccupancyGrid(0.1, 4.0), np.random.default_rng(1)
    for _ in range(200):
        grid.add_scan(np.array([[0.53, 0.56]]) + rng.normal(0.0, 0.008, (1, 2)), NO_CELLS)
    (point,) = grid.window((0.0, 0.0), (1.0, 1.0)).points()
    assert point == pytest.approx((0.53, 0.56), abs=0.006)


def test_only_changes_of_what_is_occupied_count():
    grid = OccupancyGrid(0.1, 4.0)
    seen(grid, (0.5, 0.5))
    before = grid.revision
    seen(grid, (0.5, 0.5))
    grid.add_scan(NONE, grid.cells(np.array([[1.0, 1.0]])))
    assert grid.revision == before


@settings(max_examples=30)
@given(st.lists(st.tuples(st.floats(-6, 6), st.floats(-6, 6)), min_size=1, max_size=6))
def test_what_stays_inside_is_kept_when_it_rolls_and_the_rest_forgotten(path):
    grid, known = OccupancyGrid(0.25, 4.0), {}
    for x, y in path:
        grid.centre_on(x, y)
        seen(grid, (x, y))
        row, column = grid.cells(np.array([[x, y]]))[0]
        known = {cell for cell in known if tuple(cell) in set(map(tuple, grid.occupied().tolist()))} | {(row, column)}
        corner = grid._corner
        assert all((np.array(cell) - corner >= 0).all() and (np.array(cell) - corner < 16).all() for cell in known)
    assert known == set(map(tuple, grid.occupied().tolist()))


def test_a_window_reaches_beyond_the_grid_and_knows_nothing_there():
    grid = OccupancyGrid(0.1, 2.0)
    seen(grid, (0.95, 0.05))
    window = grid.window((0.9, 0.0), (1.55, 0.05))
    assert window.states.shape == (1, 7)
    assert window.states[0].tolist() == [OCCUPIED, *[UNKNOWN] * 6]
    assert window.points() == pytest.approx(np.array([[0.95, 0.05]]))


@pytest.mark.parametrize("outside", [False, True])
@pytest.mark.parametrize("span", [None, 4.7])
def test_a_cleared_map_has_what_the_scanner_sees_and_what_it_cannot_look_at(span, outside):
    random = np.random.default_rng(7)
    for _ in range(20):
        grid, eye = OccupancyGrid(0.1, 8.0), Pose2(*random.uniform(-1, 1, 2), random.uniform(-3, 3))
        view = None if span is None else View(eye, span)
        old, now = (random.uniform(-3.9, 3.9, (60, 2)) for _ in "ab")
        grid.add_scan(old, NO_CELLS, view)
        bearing = np.arctan2(*(now - eye[:2]).T[::-1]) - eye.yaw
        now = now[np.abs(np.mod(bearing + math.pi, math.tau) - math.pi) < (span or math.tau) / 2 - 0.2]
        grid.add_scan(now, NO_CELLS, view)
        before = set(map(tuple, grid.occupied().tolist()))
        x, y, radius = *random.uniform(-2, 2, 2), random.choice([0.5, 2.0, math.inf])
        grid.clear(x, y, radius, outside=outside)
        after, seen_now = set(map(tuple, grid.occupied().tolist())), set(map(tuple, grid.cells(now).tolist()))
        for cell in before:
            (centre,) = grid.centres(np.array([cell]))
            near = (math.dist(centre, (x, y)) <= radius) != outside
            turn = math.atan2(centre[1] - eye.y, centre[0] - eye.x) - eye.yaw
            blind = span is not None and abs(wrap_angle(turn)) > span / 2
            assert (cell in after) == (cell in seen_now or blind or not near), "a clear never blinds the robot"


places = st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))


@given(st.lists(places, min_size=1, max_size=9), st.lists(places, max_size=9), places, places)
def test_points_are_those_of_the_window_of_the_same_rectangle(hits, passed, one, other):
    grid = OccupancyGrid(0.5, 4.0)
    grid.add_scan(np.array(hits), grid.cells(np.array(passed).reshape(-1, 2)))
    low, high = (tuple(edge) for edge in np.sort([one, other], axis=0).tolist())
    window = grid.window(low, high)
    assert grid.points(low, high).tolist() == window.echoes[window.states == OCCUPIED].tolist()
    assert grid.points(low, high).tolist() == window.points().tolist()


@given(st.lists(st.tuples(st.lists(places, max_size=5), st.lists(places, max_size=9)), max_size=9))
def test_a_look_tells_how_many_cells_became_occupied_or_ceased_to_be(looks):
    grid = OccupancyGrid(0.5, 4.0)
    for hits, passed in looks:
        before = set(map(tuple, grid.occupied().tolist()))
        cells = grid.cells(np.array(passed).reshape(-1, 2))
        changed = grid.add_scan(np.array(hits).reshape(-1, 2), np.vstack([cells, cells[:2]]))
        assert changed == len(before ^ set(map(tuple, grid.occupied().tolist())))


@pytest.mark.parametrize(("cell", "side"), [(0.0, 1.0), (0.1, 0.05), (0.001, 100.0), (float("nan"), 1.0)])
def test_sizes_that_make_no_grid_are_refused(cell, side):
    with pytest.raises(KnowledgeError, match="grid"):
        OccupancyGrid(cell, side)


def test_what_moves_is_an_obstacle_until_the_next_scan():
    grid, corner = OccupancyGrid(0.1, 10.0), ((-3.0, -3.0), (3.0, 3.0))
    nothing = np.zeros((0, 2), np.intp)
    for _ in range(3):
        grid.add_scan(np.array([[1.0, 1.05]]), nothing)
    assert grid.add_scan(np.array([[1.0, 1.05]]), nothing, moving=np.array([[-1.02, 0.53]])) == 0
    revision = grid.revision
    assert grid.points(*corner).tolist() == pytest.approx(np.array([[1.0, 1.05], [-1.02, 0.53]]))
    assert sorted(grid.window(*corner).points().tolist()) == pytest.approx(np.array([[-1.02, 0.53], [1.0, 1.05]]))
    assert len(grid.window(*corner, moving=False).points()) == len(grid.points(*corner, moving=False)) == 1
    assert grid.state(-1.02, 0.53) == UNKNOWN
    assert len(grid.occupied()) == 1
    grid.add_scan(np.array([[1.0, 1.05]]), nothing)
    assert grid.revision > revision
    assert len(grid.points(*corner)) == 1


@pytest.mark.parametrize("seed", range(4))
def test_cells_in_forgotten_discs_are_unknown_and_others_as_before(seed):
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid(0.1, 6.0)
    for _ in range(3):
        grid.add_scan(rng.uniform(-3.0, 3.0, (300, 2)), np.zeros((0, 2), np.intp))
    before = grid.occupied()
    centres, radii = rng.uniform(-3.5, 3.5, (4, 2)), rng.uniform(0.1, 0.6, 4)
    away = np.hypot(*(grid.centres(before)[:, None] - centres).transpose(2, 0, 1))
    gone = (away <= radii).any(axis=1)
    assert grid.forget(centres, radii) == gone.sum()
    assert grid.occupied().tolist() == before[~gone].tolist()
