"""Free turns of a hull on the spot."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from .summit_xl import gaps

SWING, TURNS, free_turns = gaps.SWING, gaps.TURNS, gaps.free_turns
HALF = (0.35, 0.275)
STEP = float(TURNS[1])


def gap(point, turn):
    """Between one point and the hull once it has turned to the left [m]."""
    x = abs(math.cos(turn) * point[0] + math.sin(turn) * point[1]) - HALF[0]
    y = abs(math.cos(turn) * point[1] - math.sin(turn) * point[0]) - HALF[1]
    return math.hypot(max(x, 0.0), max(y, 0.0)) + min(max(x, y), 0.0)  # negative inside


def test_nothing_near_lets_it_turn_all_round():
    assert free_turns(np.empty((0, 2)), HALF) == (math.pi, math.pi)
    assert free_turns(np.array([[0.6, 0.0], [0.0, -0.5]]), HALF) == (math.pi, math.pi)


def test_beside_a_wall_it_turns_until_its_corner_is_there():
    wall = np.stack([np.linspace(-1.0, 1.0, 81), np.full(81, 0.40)], axis=1)  # along its left, 0.125 m from the flank
    left, right = free_turns(wall, HALF)
    assert left == right
    # A corner is 0.35 sin(a) + 0.275 cos(a) off the axis: no nearer than SWING to the wall.
    assert 0.35 * math.sin(left) + 0.275 * math.cos(left) <= 0.40 - SWING + 1e-9
    assert 0.35 * math.sin(left + STEP) + 0.275 * math.cos(left + STEP) > 0.40 - SWING


def test_what_it_is_too_near_to_it_may_turn_from_and_not_to():
    for y in (
        0.30,
        0.275,
        0.27,
    ):  # at its left, before the middle: near to the flank, at it, and a little over its edge
        left, right = free_turns(np.array([[0.3, y]]), HALF)
        assert left == 0.0
        assert 1.0 < right < math.pi


@given(
    st.lists(st.tuples(st.floats(0.2, 0.6), st.floats(-math.pi, math.pi)), min_size=1, max_size=8),
    st.floats(0.0, 1.0),
    st.sampled_from([1.0, -1.0]),
)
def test_on_all_its_free_turn_it_comes_no_nearer_than_it_is_or_may(points, share, side):
    points = [(r * math.cos(a), r * math.sin(a)) for r, a in points]
    room = free_turns(np.array(points), HALF)[0 if side > 0.0 else 1]
    turn = side * round(share * room / STEP) * STEP
    assert all(gap(point, turn) >= min(SWING, gap(point, 0.0)) - 1e-6 for point in points)


@given(st.tuples(st.floats(0.2, 0.6), st.floats(-math.pi, math.pi)))
def test_what_lies_to_the_left_is_to_a_turn_to_the_left_what_lies_to_the_right_to_the_other(at):
    point = np.array([[at[0] * math.cos(at[1]), at[0] * math.sin(at[1])]])
    assert free_turns(point, HALF) == tuple(reversed(free_turns(point * (1.0, -1.0), HALF)))
    assert free_turns(point, HALF) == pytest.approx(free_turns(-point, HALF))
