"""Elastic-band smoothing on random windows of a map: its result is finite, and what is held stays where it is."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from rocs_bt.control.elastic_band import STEP, DistanceField, relaxed
from rocs_bt.control.footprint import Footprint

CELL = 0.05
place = st.tuples(st.floats(-1.0, 3.0), st.floats(-1.0, 3.0))


def window(rows, columns, things, reach):
    """A window of the map, whose distances end at `reach` [m] as those of `grid_astar` do."""
    row, column = np.indices((rows, columns))
    centres = CELL * (np.stack([column, row], axis=-1) + 0.5)
    points = np.array(things, dtype=float).reshape(-1, 2)
    away = np.full((rows, columns), reach)
    for point in points:
        away = np.minimum(away, np.hypot(*np.moveaxis(centres - point, -1, 0)))
    return DistanceField(0.0, 0.0, CELL, away, points)


@given(
    st.integers(2, 40),
    st.integers(2, 40),
    st.lists(place, max_size=8),
    st.floats(0.05, 1.5),
    st.floats(0.1, 2.0),
    st.floats(0.1, 2.0),
    place,
    st.lists(st.floats(-3.2, 3.2), min_size=1, max_size=40),
    st.integers(0, 45),
)
@example(20, 20, [], 0.5, 2.0, 0.1, (0.0, 0.5), [0.0] * 10, 0)
@example(20, 20, [(0.5, 0.5)], 0.5, 0.5, 0.4, (0.0, 0.5), [0.0] * 10, 0)
def test_any_window_gives_a_finite_path_whose_ends_are_held(
    rows, columns, things, reach, length, width, start, turns, fixed
):
    steps = STEP * np.column_stack([np.cos(turns), np.sin(turns)])
    path = np.vstack([start, start + np.cumsum(steps, axis=0)])
    around = window(rows, columns, things, reach)
    with np.errstate(all="raise", under="ignore"):
        band = relaxed(around, Footprint(length, width), path, fixed)
    assert band.shape == path.shape
    assert np.isfinite(band).all()
    held = [*range(min(max(fixed, 1), len(path))), -1]
    assert band[held] == pytest.approx(path[held])


def test_distances_that_say_near_where_nothing_is_give_the_path_of_free_ground():
    path = np.column_stack([np.arange(12) * STEP, np.full(12, 1.0)])
    hull = Footprint(0.5, 0.4)
    free = relaxed(window(40, 40, [], 2.0), hull, path, 0)
    assert relaxed(window(40, 40, [], 0.3), hull, path, 0) == pytest.approx(free)
