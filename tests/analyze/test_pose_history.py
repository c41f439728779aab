"""PoseHistory: poses between samples, across the wrap of the heading, and what is not known."""

import math

import numpy as np
import pytest

from rocs_bt.analyze.pose_history import PoseHistory
from rocs_bt.base.geometry import Pose2
from rocs_bt.interfaces.channel import Stamped


def history(*poses):
    kept = PoseHistory()
    kept.take([Stamped(0.1 * k, "pose", {"pose": list(pose)}) for k, pose in enumerate(poses)])
    return kept


@pytest.mark.parametrize("seed", range(3))
def test_a_robot_that_turns_steadily_is_where_it_is_at_each_moment(seed):
    rng = np.random.default_rng(seed)
    x, yaw, speed, turn = rng.uniform(-3.0, 3.0, 4)
    poses = [((x + 0.1 * k * speed), 1.0, math.remainder(yaw + 0.1 * k * turn, math.tau)) for k in range(6)]
    kept = history(*poses)
    for t in [*rng.uniform(0.0, 0.5, 8), 0.5]:
        found = kept.at(float(t))
        assert found[:2] == pytest.approx((x + t * speed, 1.0))
        assert math.cos(found.yaw - yaw - t * turn) == pytest.approx(1.0)
        assert kept.along(np.array([t]))[0, :2] == pytest.approx(found[:2])


def test_before_and_after_what_is_known_the_nearest_pose_counts():
    kept = history((1.0, 2.0, 3.0), (2.0, 2.0, -3.0))
    assert kept.at(-1.0) == pytest.approx(Pose2(1.0, 2.0, 3.0))
    assert kept.at(9.0) == pytest.approx(Pose2(2.0, 2.0, -3.0))


def test_what_is_not_known_is_none():
    assert PoseHistory().at(0.0) is None
    lost = history((0.0, 0.0, 0.0), (math.nan,) * 3)
    assert lost.at(0.1) is None
    assert lost.at(0.05) is None
    assert lost.along(np.array([0.0, 0.1])) is None


@pytest.mark.parametrize("period", [0.005, 0.01, 0.05, 0.1])
@pytest.mark.parametrize("late", [0.0, 0.1, 0.4, 0.9])
def test_a_late_scan_finds_its_pose_whatever_the_period(period, late):
    kept, now = PoseHistory(), 3.0
    for k in range(1, round(now / period) + 1):
        t = k * period
        kept.take([Stamped(t, "pose", {"pose": [t, -t, math.remainder(2.0 * t, math.tau)]})])
    taken = now - late - 0.3 * period
    found = kept.along(np.array([taken, taken + 0.3 * period]))
    assert found[:, 0] == pytest.approx([taken, taken + 0.3 * period])
    assert found[1, 2] - found[0, 2] == pytest.approx(0.6 * period)
    assert kept.at(taken)[:2] == pytest.approx((taken, -taken))
