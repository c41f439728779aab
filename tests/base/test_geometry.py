"""Angles and poses."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.geometry import Pose2, Pose3, Twist2, Twist3, along_arc, arc, arc_positions, wrap_angle

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


def _about(axis, angle):
    """Rotation matrix of an angle about a coordinate axis."""
    c, s, matrix = math.cos(angle), math.sin(angle), np.eye(3)
    i, j = (axis + 1) % 3, (axis + 2) % 3
    matrix[i, i], matrix[i, j], matrix[j, i], matrix[j, j] = c, -s, s, c
    return matrix


rolls = st.floats(-3.1, 3.1)


@given(rolls, st.floats(-1.55, 1.55), rolls)
def test_a_quaternion_becomes_roll_pitch_and_yaw_about_the_axes_of_the_world(roll, pitch, yaw):
    import mujoco

    matrix, quaternion = _about(2, yaw) @ _about(1, pitch) @ _about(0, roll), np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, matrix.ravel())
    pose = Pose3.from_quaternion((1.0, 2.0, 3.0), quaternion)
    assert pose == pytest.approx((1.0, 2.0, 3.0, roll, pitch, yaw), abs=1e-6)
    assert math.cos(pose.tilt) == pytest.approx(matrix[2, 2], abs=1e-6)
    assert Pose3.from_quaternion(pose[:3], pose.quaternion) == pytest.approx(pose, abs=1e-6)
    assert pose.plane == Pose2(pose.x, pose.y, pose.yaw)


def test_a_pose_with_its_nose_straight_down_is_tilted_by_a_right_angle():
    half = math.sqrt(0.5)
    pose = Pose3.from_quaternion((0.0, 0.0, 0.5), (half, 0.0, half + 1e-16, 0.0))
    assert (pose.pitch, pose.tilt) == (pytest.approx(math.pi / 2), pytest.approx(math.pi / 2))


def test_twists_of_the_plane_and_of_space_name_the_same_components():
    assert Twist3(0.4, 0.1, 0.2, 0.3).plane == Twist2(0.4, 0.3, 0.1)
    assert Twist3(0.4) == (0.4, 0.0, 0.0, 0.0)
    assert Twist2(0.4, 0.3, 0.1).up == 0.0
