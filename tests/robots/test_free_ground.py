"""FreeGround: map of free ground that moves with the robot."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.geometry import Pose2

from .summit_xl import free_ground

FreeGround = free_ground.FreeGround
ORIGIN = Pose2(0.0, 0.0, 0.0)
near = st.floats(-2.0, 2.0)
poses = st.builds(Pose2, near, near, st.floats(-math.pi, math.pi))


def free(ground, points, since):
    """(k,) Whether each of some points (k, 2) was known to be free: ways of one stride and one point."""
    return np.array(ground.strides(ORIGIN, points[:, None, None], since), bool)


def test_what_was_marked_is_free_for_as_long_as_is_asked():
    ground = FreeGround()
    ground.centre(ORIGIN)
    here, there = np.array([[0.55, 0.05]]), np.array([[0.85, 0.05]])
    ground.mark(ORIGIN, here, 3.0)
    assert free(ground, here, 3.0).all()
    assert not free(ground, here, 3.1).any()
    assert not free(ground, there, 0.0).any()
    ground.mark(ORIGIN, here, -math.inf)
    assert not free(ground, here, 0.0).any()


def test_it_goes_with_the_robot_and_forgets_what_is_left_behind():
    ground = FreeGround(size=40)  # 4 m
    ground.centre(ORIGIN)
    spot = np.array([[0.05, 0.05]])
    ground.mark(ORIGIN, spot, 1.0)
    for x in (0.9, 1.5):
        ground.centre(Pose2(x, 0.0))
        assert free(ground, spot, 1.0).all()
    ground.centre(Pose2(9.0, 0.0))
    ground.centre(ORIGIN)
    assert not free(ground, spot, 0.0).any()


def test_nothing_is_known_beyond_its_edge():
    ground = FreeGround(size=40)
    ground.centre(ORIGIN)
    beyond = np.array([[2.05, 0.05], [-2.05, 0.05], [0.05, 5.0]])
    ground.mark(ORIGIN, beyond, 1.0)
    assert not free(ground, np.vstack([beyond, beyond - 4.0, beyond + 4.0]), 0.0).any()


def test_a_way_ends_before_the_first_stride_that_is_not_all_free():
    ground = FreeGround()
    ground.centre(ORIGIN)
    ground.mark(ORIGIN, np.array([[0.05, 0.05], [0.15, 0.05], [0.35, 0.05], [0.05, 0.15], [0.15, 0.15]]), 2.0)
    strides = np.array([0.05, 0.15, 0.25, 0.35])
    lane = np.stack([strides, np.full(4, 0.05)], axis=-1)[:, None]
    wide = np.concatenate([lane, lane + np.array([0.0, 0.1])], axis=1)
    assert ground.strides(ORIGIN, np.stack([wide, wide[::-1]]), 2.0) == [2, 0]
    assert ground.strides(ORIGIN, lane[None], 2.0) == [2]
    assert ground.strides(ORIGIN, lane[None, :2], 2.0) == [2]
    assert ground.strides(ORIGIN, lane[None], 2.1) == [0]


@given(st.lists(st.tuples(poses, st.lists(st.tuples(near, near), min_size=1, max_size=8)), max_size=6), poses)
def test_it_is_what_a_set_of_squares_would_be(marks, centre):
    ground, squares = FreeGround(size=200), set()
    ground.centre(centre)
    for at, points in marks:
        ground.mark(at, np.array(points), 1.0)
        squares |= {tuple(math.floor(v / 0.1) for v in at.transform(*p)) for p in points}
    asked = np.array([[0.1 * i + 0.05, 0.1 * j + 0.05] for i in range(-25, 25) for j in range(-25, 25)])
    found = {(math.floor(x / 0.1), math.floor(y / 0.1)) for x, y in asked[free(ground, asked, 1.0)].tolist()}
    inside = {s for s in squares if all(-25 <= k < 25 for k in s)}
    # Points on the very edge of a square may be counted to either side.
    assert len(found ^ inside) <= 2 * sum(
        any(abs(v / 0.1 - round(v / 0.1)) < 1e-6 for v in at.transform(*p)) for at, points in marks for p in points
    )
