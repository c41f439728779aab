"""The trail: which poses it keeps, and which ground they cover."""

import math

import numpy as np
import pytest

from rocs_bt.base.geometry import Pose2
from rocs_bt.control.footprint import Footprint
from rocs_bt.control.trail import LENGTH, SPACING, TURNED, Trail

BODY = Footprint(0.6, 0.4)


def covered(trail, *points):
    return trail.covers(np.array(points, dtype=float).reshape(-1, 2), BODY).tolist()


def test_nothing_is_covered_before_the_first_known_pose():
    trail = Trail()
    assert covered(trail, (0.0, 0.0)) == [False]
    trail.add(Pose2(0.0, math.nan, 0.0))
    assert covered(trail, (0.0, 0.0), (1.0, 1.0)) == [False, False]
    trail.add(Pose2(0.0, 0.0, 0.0))
    assert covered(trail, (0.0, 0.0)) == [True]
    assert covered(trail) == []


@pytest.mark.parametrize("yaw", [0.0, 0.7, -2.5, math.pi])
def test_the_ground_below_the_hull_is_covered_and_no_other(yaw):
    trail, poses = Trail(), (Pose2(1.0, -2.0, yaw), Pose2(3.0, 1.0, yaw))
    for pose in poses:
        trail.add(pose)
    for pose in poses:
        inside = [pose.transform(x, y) for x in (-0.29, 0.0, 0.29) for y in (-0.19, 0.19)]
        outside = [pose.transform(x, y) for x, y in ((0.32, 0.0), (-0.32, 0.1), (0.0, 0.22), (0.1, -0.22))]
        assert covered(trail, *inside, *outside) == [True] * 6 + [False] * 4


@pytest.mark.parametrize(
    ("step", "kept"),
    [
        (Pose2(0.9 * SPACING, 0.0, 0.0), False),
        (Pose2(1.1 * SPACING, 0.0, 0.0), True),
        (Pose2(0.0, 0.0, 0.9 * TURNED), False),
        (Pose2(0.0, 0.0, -1.1 * TURNED), True),
    ],
)
def test_a_pose_is_kept_after_some_way_or_turn(step, kept):
    trail = Trail()
    trail.add(Pose2(0.0, 0.0, 0.0))
    trail.add(step)
    corner = step.transform(0.299, 0.199 if step.yaw <= 0.0 else -0.199)  # outside of the first hull
    assert covered(trail, (0.0, 0.0), corner) == [True, kept]


def test_the_turn_across_the_seam_is_small():
    trail = Trail()
    trail.add(Pose2(0.0, 0.0, math.pi - 0.01))
    trail.add(Pose2(0.0, 0.0, -math.pi + 0.04))
    assert covered(trail, Pose2(0.0, 0.0, -math.pi + 0.04).transform(0.299, 0.199)) == [False]


def test_the_oldest_poses_are_forgotten():
    trail = Trail()
    for i in range(LENGTH + 1):
        trail.add(Pose2(0.05 * i, 0.0, 0.0))
    assert covered(trail, (-0.29, 0.0), (-0.24, 0.0), (0.05 * LENGTH, 0.0)) == [False, True, True]
