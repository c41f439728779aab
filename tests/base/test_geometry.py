"""Angles and poses."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.geometry import Pose2, Twist2, along_arc, arc, arc_positions, wrap_angle

angles = st.floats(-50.0, 50.0)
coordinates = st.floats(-100.0, 100.0)
poses = st.builds(Pose2, coordinates, coordinates, angles.map(wrap_angle))


@given(angles)
def test_a_wrapped_angle_points_the_same_way(angle):
    wrapped = wrap_angle(angle)
    assert -math.pi < wrapped <= math.pi
    assert math.cos(wrapped) == pytest.approx(math.cos(angle), abs=1e-9)
    assert math.sin(wrapped) == pytest.approx(math.sin(angle), abs=1e-9)


def test_west_is_plus_pi():
    assert wrap_angle(math.pi) == wrap_angle(-math.pi) == math.pi


@given(poses, poses)
def test_the_bearing_leads_to_the_other_pose(a, b):
    d, bearing = a.distance(b), a.bearing(b)
    x, y = a.transform(d * math.cos(bearing), d * math.sin(bearing))
    assert (x, y) == (pytest.approx(b.x, abs=1e-6), pytest.approx(b.y, abs=1e-6))


@given(poses, poses, poses)
def test_composition_is_associative(a, b, c):
    left, right = a.compose(b).compose(c), a.compose(b.compose(c))
    assert left[:2] == pytest.approx(right[:2], abs=1e-6)
    assert abs(wrap_angle(left.yaw - right.yaw)) < 1e-9


@given(poses, st.builds(Twist2, *[st.floats(-3.0, 3.0)] * 3), st.lists(st.floats(-5.0, 5.0), max_size=8))
def test_an_arc_is_its_single_places_to_the_bit(pose, twist, durations):
    single = [along_arc(pose, twist, duration) for duration in durations]
    assert arc(pose, twist, durations) == single
    assert arc_positions(pose, twist, durations) == [(place.x, place.y) for place in single]
