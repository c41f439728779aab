"""Footprint: gaps to a rectangle, against a fine polygon, and the time of a contact, against stepping the motion."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2, Twist2, along_arc
from rocs_bt.control.footprint import CLOSING, Footprint

HULL = Footprint(0.5, 0.4)
TIMES = np.arange(1, 41) * 0.05
near = st.floats(-1.5, 1.5)


def rim(n=4000):
    t = np.linspace(0.0, 1.0, n // 4)
    x, y = 0.25, 0.2
    sides = [((x, -y), (x, y)), ((x, y), (-x, y)), ((-x, y), (-x, -y)), ((-x, -y), (x, -y))]
    return np.vstack([np.outer(1 - t, a) + np.outer(t, b) for a, b in sides])


@given(near, near)
def test_a_gap_is_that_to_the_rim_and_inside_its_depth(x, y):
    least = np.hypot(*(rim() - (x, y)).T).min()
    inside = abs(x) < 0.25 and abs(y) < 0.2
    assert HULL.gap(np.array(x), np.array(y)) == pytest.approx(-least if inside else least, abs=1e-3)


@given(near, near, st.floats(-math.pi, math.pi), st.lists(st.tuples(near, near), min_size=1, max_size=9))
def test_clearance_is_the_least_gap_in_the_body_frame(x, y, yaw, points):
    c, s = math.cos(yaw), math.sin(yaw)
    body = [(c * (px - x) + s * (py - y), c * (py - y) - s * (px - x)) for px, py in points]
    found = HULL.clearance(np.array([[x, y, yaw]]), np.array(points))
    assert found[0] == pytest.approx(min(HULL.gap(*np.array(body).T)), abs=1e-9)


pose = st.tuples(near, near, st.floats(-7.0, 7.0))


@given(st.lists(pose, min_size=1, max_size=14), st.lists(st.tuples(near, near), min_size=1, max_size=9))
def test_each_of_many_poses_has_the_clearance_that_it_has_alone(poses, points):
    poses, points = np.array(poses), np.array(points)
    alone = [min(HULL.clearance(one[None], point[None])[0] for point in points) for one in poses]
    assert HULL.clearance(poses, points).tolist() == alone


def test_without_points_all_is_clear():
    assert HULL.clearance(np.empty((0, 3)), np.ones((1, 2))).tolist() == []
    assert HULL.clearance(np.zeros((2, 3)), np.empty((0, 2))).tolist() == [math.inf, math.inf]
    assert HULL.contact_time(np.empty((0, 2)), Twist2(1.0), TIMES) == math.inf


@given(st.floats(-2, 2), st.floats(-2, 2), st.lists(st.tuples(near, near), min_size=1, max_size=5))
def test_contact_comes_when_the_driven_hull_reaches_a_point(forward, turn, points):
    points = np.array([p for p in points if HULL.gap(*np.array(p)) > 0.03]).reshape(-1, 2)
    expected = math.inf
    for t in TIMES:
        pose = np.array([along_arc(Pose2(0.0, 0.0), Twist2(forward, turn), t)])
        if len(points) and HULL.clearance(pose, points)[0] < 0.0:
            expected = t
            break
    assert HULL.contact_time(points, Twist2(forward, turn), TIMES) == pytest.approx(expected)


def test_who_stands_close_may_leave_or_pass():
    wall = np.column_stack([np.linspace(-1, 1, 50), np.full(50, 0.205)])  # 5 mm beside it
    assert HULL.contact_time(wall, Twist2(0.5), TIMES) == math.inf
    assert HULL.contact_time(wall, Twist2(0.5, 0.3), TIMES) < 0.5
    inside = np.array([[0.25 - 0.5 * CLOSING, 0.0]])
    assert HULL.contact_time(inside, Twist2(-0.5), TIMES) == math.inf
    assert HULL.contact_time(inside, Twist2(0.5), TIMES) < 0.5


def test_a_hull_without_a_side_is_refused():
    with pytest.raises(InputError, match="positive length and width"):
        Footprint(0.0, 0.4)


def test_what_is_not_touched_yet_is_touched_however_near_it_is():
    assert HULL.contact_time(np.array([[0.253, 0.1]]), Twist2(0.2), TIMES) == pytest.approx(TIMES[0])
    assert HULL.contact_time(np.array([[0.1, 0.203]]), Twist2(0.2), TIMES) == math.inf  # it slides by
