"""Prediction: gaps to discs that move, against sampled outlines, and the time of a collision, against stepping."""

import math

import numpy as np
import pytest

from rocs_bt.base.geometry import Pose2, Twist2, along_arc
from rocs_bt.control.footprint import Footprint
from rocs_bt.control.prediction import Prediction, displaced
from rocs_bt.knowledge import Movers

HULL = Footprint(0.5, 0.4)


def sampled(rng, rows=4, steps=6):
    times = 3.0 + np.cumsum(rng.uniform(0.1, 0.6, steps))
    positions, ids = rng.uniform(-3.0, 3.0, (rows, steps, 2)), np.arange(rows)
    return Prediction(
        times, positions, rng.uniform(0.1, 0.4, rows), rng.uniform(0.0, 0.3, (rows, steps)), ids + 1.0, ids, ids
    )


def where(prediction, row, t):
    return np.array([np.interp(t, prediction.times, prediction.positions[row, :, axis]) for axis in (0, 1)])


def outline(pose, n=1500):
    """Points on the rim of the hull at a pose, and whether a point is inside of it."""
    part = np.linspace(-0.5, 0.5, n // 4)
    x, y, edge = HULL.length * part, HULL.width * part, np.full(n // 4, 0.5)
    body = np.vstack(
        [
            np.column_stack(side)
            for k in (-1.0, 1.0)
            for side in ((x, k * HULL.width * edge), (k * HULL.length * edge, y))
        ]
    )
    c, s = math.cos(pose[2]), math.sin(pose[2])
    return body @ np.array([[c, s], [-s, c]]) + pose[:2]


def inside(pose, point):
    c, s = math.cos(pose[2]), math.sin(pose[2])
    dx, dy = np.array(point) - pose[:2]
    return abs(c * dx + s * dy) < 0.5 * HULL.length and abs(c * dy - s * dx) < 0.5 * HULL.width


@pytest.mark.parametrize("seed", range(8))
def test_gaps_are_those_of_a_finely_sampled_outline_at_the_moment_of_each_pose(seed):
    rng = np.random.default_rng(seed)
    prediction = sampled(rng)
    n = 12
    poses = np.column_stack([rng.uniform(-2.0, 2.0, (n, 2)), rng.uniform(-7.0, 7.0, n)])
    times = rng.uniform(2.5, prediction.times[-1] + 0.5, n)
    gaps = prediction.gaps(HULL, poses, times)
    assert gaps.shape == (n, len(prediction))
    for i, pose in enumerate(poses):
        rim = outline(pose)
        for row in range(len(prediction)):
            centre = where(prediction, row, times[i])
            away = np.hypot(*(rim - centre).T).min() * (-1.0 if inside(pose, centre) else 1.0)
            assert gaps[i, row] == pytest.approx(away - prediction.radius[row], abs=2e-3)


def test_one_time_for_all_poses_is_that_time_for_each():
    rng = np.random.default_rng(9)
    prediction, poses = sampled(rng), rng.uniform(-2.0, 2.0, (7, 3))
    each = prediction.gaps(HULL, poses, np.full(7, prediction.times[2] + 0.05))
    assert prediction.gaps(HULL, poses, prediction.times[2:3] + 0.05).tolist() == each.tolist()


@pytest.mark.parametrize("seed", range(4))
def test_margins_are_interpolated_like_positions(seed):
    rng = np.random.default_rng(seed)
    prediction = sampled(rng)
    times = rng.uniform(2.5, prediction.times[-1] + 0.5, 9)
    positions, margin = prediction.at(times)
    for row in range(len(prediction)):
        assert margin[:, row] == pytest.approx(np.interp(times, prediction.times, prediction.margin[row]))
        assert positions[:, row] == pytest.approx(np.array([where(prediction, row, t) for t in times]))


@pytest.mark.parametrize("seed", range(30))
def test_a_collision_comes_when_the_driven_outline_reaches_a_disc(seed):
    rng = np.random.default_rng(seed)
    walked = np.column_stack([rng.uniform(-3.0, 3.0, (3, 2)), rng.uniform(-1.0, 1.0, (3, 2))])
    prediction = Movers.of(5.0, walked).predict([5.0, 6.0, 7.5])
    pose, twist = Pose2(*rng.uniform(-1.0, 1.0, 3)), Twist2(*rng.uniform(-1.5, 1.5, 2))
    span = prediction.times[-1] - prediction.times[0]
    expected, least = math.inf, math.inf
    for t in np.arange(0.0, span + 1e-9, 0.004):
        now = np.array([along_arc(pose, twist, float(t))])
        gaps = prediction.gaps(HULL, now, prediction.times[:1] + t)
        least = min(least, gaps.min())
        if t == 0.0:
            before = gaps
        if (gaps < np.where(before > 0.0, 0.0, before - 0.008)).any():
            expected = min(expected, float(t))
    found, nearest = prediction.contact(HULL, pose, twist)
    assert nearest == pytest.approx(least, abs=0.12)
    if math.isinf(expected):
        assert math.isinf(found)
    elif least < -0.12:  # else a touch between two steps may be missed
        assert expected <= found + 4e-3 <= expected + 0.055


def test_with_nobody_there_nothing_collides():
    nobody = Movers.of(0.0, np.empty((0, 4))).predict([0.0, 1.0])
    assert nobody.gaps(HULL, np.zeros((3, 3)), np.zeros(3)).shape == (3, 0)
    assert nobody.contact(HULL, Pose2(0.0, 0.0), Twist2(1.0)) == (math.inf, math.inf)


def test_a_robot_may_leave_what_touches_it_but_not_push_it():
    touching = Movers.of(0.0, np.array([[0.49, 0.0, 0.0, 0.0]])).predict([0.0, 1.0])
    assert touching.contact(HULL, Pose2(0.0, 0.0), Twist2(-0.5))[0] == math.inf
    assert touching.contact(HULL, Pose2(0.0, 0.0), Twist2(0.5))[0] <= 0.05


def test_rows_below_a_weight_can_be_left_out():
    prediction = sampled(np.random.default_rng(1))
    assert len(prediction.above(0.0)) == len(prediction)
    assert prediction.above(2.5).weight.tolist() == [3.0, 4.0]
    assert prediction.above(2.5).owner.tolist() == [2, 3]


@pytest.mark.parametrize("rate", [-1.5, -1e-9, 0.0, 0.3, 2.0])
def test_a_mover_at_a_constant_turn_rate_follows_an_arc(rate):
    velocity, ahead = np.array([[0.6, 0.8], [-1.0, 0.0]]), np.array([0.0, 0.5, 2.0])
    found = displaced(velocity, np.full(2, rate), ahead)
    for (vx, vy), row in zip(velocity, found, strict=True):
        start = Pose2(0.0, 0.0, math.atan2(vy, vx))
        arcs = [along_arc(start, Twist2(math.hypot(vx, vy), rate), t) for t in ahead]
        assert row == pytest.approx(np.array([(pose.x, pose.y) for pose in arcs]), abs=1e-8)
