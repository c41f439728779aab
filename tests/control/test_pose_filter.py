"""The pose filter against least squares over all that was ever said, against brute force, and on its own word."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.geometry import Pose2, Twist2, along_arc, wrap_angle
from rocs_bt.control.pose_filter import PoseFilter, PoseNoise

# Signs of life of a filter whose sensors say nothing wrong.
EXACT = PoseNoise(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1e-3, 1e-3)


def test_the_linear_case_is_least_squares_over_everything():
    # A robot that drives straight on and knows its heading: all is linear, so the filter must be the exact estimate.
    noise = PoseNoise(travel=0.1, slip=0.05, turn=0.0, drift=0.02, fix_position=0.3, fix_heading=1e-9)
    rng, yaw, steps, dt = np.random.default_rng(1), 0.7, 40, 0.1
    c, s = math.cos(yaw), math.sin(yaw)
    ways, fixes = rng.uniform(0.0, 0.2, steps), {int(i): rng.normal(0.0, 1.0, 2) for i in (0, 3, 4, 11, 25, 38)}
    made = PoseFilter(Pose2(*fixes[0], yaw), noise)
    rows, right = [_row(0, 2 * steps, 0.3, axis) for axis in (0, 1)], list(fixes[0] / 0.3)
    for i in range(1, steps):
        made.predict(ways[i], 0.0, 0.0, dt)
        turn = np.array([[c, -s], [s, c]])
        spread = turn @ np.diag([0.1**2 * ways[i], 0.05**2 * ways[i]]) @ turn.T + 0.02**2 * dt * np.eye(2)
        whiten = np.linalg.inv(np.linalg.cholesky(spread))
        step = np.zeros((2, 2 * steps))
        step[:, 2 * i : 2 * i + 2], step[:, 2 * i - 2 : 2 * i] = whiten, -whiten
        rows += [*step]
        right += [*(whiten @ (ways[i] * np.array([c, s])))]
        if i in fixes:
            made.fix_position(*fixes[i])
            rows += [_row(i, 2 * steps, 0.3, axis) for axis in (0, 1)]
            right += [*(fixes[i] / 0.3)]
    matrix = np.array(rows)
    found, *_ = np.linalg.lstsq(matrix, np.array(right), rcond=None)
    covariance = np.linalg.inv(matrix.T @ matrix)
    assert made.state[:2] == pytest.approx(found[-2:], abs=1e-9)
    assert made.covariance[:2, :2] == pytest.approx(covariance[-2:, -2:], abs=1e-9)


def _row(i, size, deviation, axis):
    row = np.zeros(size)
    row[2 * i + axis] = 1.0 / deviation
    return row


MOTION = st.tuples(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5), st.floats(-2.0, 2.0))


@settings(max_examples=80, deadline=None)
@given(motion=MOTION, yaw=st.floats(-3.1, 3.1))
def test_the_prediction_is_the_arc(motion, yaw):
    forward, left, turn = motion
    for rate in (math.nan, turn / 0.5):
        made = PoseFilter(Pose2(1.0, 2.0, yaw), EXACT)
        made.predict(forward, left, turn if math.isnan(rate) else 9.9, 0.5, rate)
        arc = along_arc(Pose2(1.0, 2.0, yaw), Twist2(forward, turn, left), 1.0)
        assert made.pose[:2] == pytest.approx(arc[:2], abs=1e-9)
        assert wrap_angle(made.pose.yaw - arc.yaw) == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(motion=MOTION, yaw=st.floats(-3.1, 3.1), bias=st.floats(-0.3, 0.3))
def test_the_covariance_is_carried_by_the_slopes_of_the_prediction(motion, yaw, bias):
    forward, left, turn = motion
    noise = PoseNoise(0.0, 0.0, 0.3, 0.2, 0.0, 0.0, 1e-3, 1e-3)
    for rate in (math.nan, turn / 0.5):

        def end(state, by=0.0, rate=rate):
            made = PoseFilter(Pose2(0.0, 0.0), EXACT)
            made.state = np.array(state)
            made.predict(forward, left, turn + by, 0.5, rate + by / 0.5)
            return np.array([*made.state[:2], state[2] + wrap_angle(made.state[2] - state[2]), made.state[3]])

        start, size = np.array([0.3, -0.2, yaw, bias]), 1e-6
        slope = np.column_stack([(end(start + d) - end(start - d)) / (2.0 * size) for d in size * np.eye(4)])
        by_turn = (end(start, size) - end(start, -size)) / (2.0 * size)
        made = PoseFilter(Pose2(0.0, 0.0), noise)
        made.state, made.covariance = start, np.diag([0.1, 0.2, 0.3, 0.4])
        way = math.hypot(forward, left)
        variance = 0.3**2 * (abs(turn) + way) if math.isnan(rate) else (0.2 * 0.5) ** 2
        wanted = slope @ np.diag([0.1, 0.2, 0.3, 0.4]) @ slope.T + variance * np.outer(by_turn, by_turn)
        made.predict(forward, left, turn, 0.5, rate)
        assert made.covariance == pytest.approx(wanted, abs=1e-6)


def drive(rng, noise, gyro, steps=200):
    """The filter's normalised squared errors along one drive whose noise is what the filter takes for granted."""
    true, bias, dt = Pose2(1.0, -1.0, rng.uniform(-3.1, 3.1)), noise.gyro_bias * rng.normal(), 0.05
    made = PoseFilter(
        Pose2(
            true.x + noise.fix_position * rng.normal(),
            true.y + noise.fix_position * rng.normal(),
            wrap_angle(true.yaw + noise.fix_heading * rng.normal()),
        ),
        noise,
    )
    found = []
    for i in range(1, steps + 1):
        way, turn = 0.025, 0.05 * math.sin(0.02 * i)
        true = along_arc(true, Twist2(way + noise.travel * math.sqrt(way) * rng.normal(), turn), 1.0)
        x, y = true.transform(0.0, noise.slip * math.sqrt(way) * rng.normal())
        east, north = noise.drift * math.sqrt(dt) * rng.normal(size=2)
        true = Pose2(x + east, y + north, true.yaw)
        told = turn + noise.turn * math.sqrt(abs(turn) + way) * rng.normal()
        made.predict(way, 0.0, told, dt, turn / dt + bias + noise.gyro * rng.normal() if gyro else math.nan)
        if i % 10 == 0:
            made.fix_position(true.x + noise.fix_position * rng.normal(), true.y + noise.fix_position * rng.normal())
            made.fix_heading(wrap_angle(true.yaw + noise.fix_heading * rng.normal()))
            error = np.array([made.pose.x - true.x, made.pose.y - true.y, wrap_angle(made.pose.yaw - true.yaw)])
            found.append(error @ np.linalg.solve(made.covariance[:3, :3], error))
    return found, made.state[3] - bias, made.covariance[3, 3]


@pytest.mark.parametrize("gyro", [True, False])
def test_its_errors_are_of_the_size_that_it_says(gyro):
    from scipy.stats import chi2

    noise = PoseNoise(0.02, 0.02, 0.05, 0.01, 0.03, 0.005, 0.05, 0.09)
    runs = [drive(np.random.default_rng([gyro, seed]), noise, gyro) for seed in range(60)]
    for moment in (0, 5, -1):  # one moment of each run: those of one run depend on each other
        total = sum(run[0][moment] for run in runs)
        low, high = chi2.ppf([0.0005, 0.9995], 3 * len(runs))
        assert low < total < high, moment
    if gyro:
        errors = [run[1] / math.sqrt(run[2]) for run in runs]
        assert np.std(errors) == pytest.approx(1.0, abs=0.35)
        assert max(run[2] for run in runs) < (0.5 * noise.gyro_bias) ** 2, "the bias is learned"


@settings(max_examples=40, deadline=None)
@given(yaw=st.floats(-math.pi, math.pi), away=st.floats(-1.0, 1.0))
def test_headings_are_corrected_the_short_way_round(yaw, away):
    made = PoseFilter(Pose2(0.0, 0.0, yaw), PoseNoise(fix_heading=0.1))
    made.fix_heading(wrap_angle(yaw + away))
    assert wrap_angle(made.pose.yaw - yaw) == pytest.approx(0.5 * away, abs=1e-9)
    assert -math.pi < made.pose.yaw <= math.pi


@pytest.mark.parametrize("turned", [1.0, math.pi, -3.0])
def test_a_world_that_is_turned_turns_the_estimate_and_nothing_else(turned):
    def run(by):
        origin = Pose2(0.0, 0.0, by)
        made = PoseFilter(origin.compose(Pose2(1.0, 0.5, 2.9)))
        for i in range(60):
            made.predict(0.02, 0.0, 0.03, 0.05)
            if i % 10 == 9:
                made.fix_position(*origin.transform(1.0 - 0.02 * i, 0.6))
                made.fix_heading(wrap_angle(2.9 + 0.03 * i + by))
        return origin, made

    (_, plain), (origin, other) = run(0.0), run(turned)
    expected = origin.compose(plain.pose)
    assert other.pose[:2] == pytest.approx(expected[:2], abs=1e-9)
    assert wrap_angle(other.pose.yaw - expected.yaw) == pytest.approx(0.0, abs=1e-9)
    assert other.spread == pytest.approx(plain.spread, abs=1e-12)


def test_without_fixes_it_grows_less_sure_and_a_doubt_widens_it():
    made, spreads = PoseFilter(Pose2(0.0, 0.0)), []
    for _ in range(30):
        made.predict(0.02, 0.0, 0.01, 0.05)
        spreads.append(made.spread)
    assert spreads == sorted(spreads)
    before = made.covariance[2, 2]
    made.widen(1.0, 0.5)
    assert made.spread > 1.0
    assert made.covariance[2, 2] == pytest.approx(before + 0.25)
