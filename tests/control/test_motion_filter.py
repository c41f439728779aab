"""The motion filter against brute force, and on trajectories that are known."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.geometry import Pose2, Twist2, along_arc
from rocs_bt.control.motion_filter import MotionFilter, MotionNoise

HERE = Pose2(0.0, 0.0, 0.3)
EXACT = MotionNoise(range=1e-3, bearing=1e-3, acceleration=0.0, turning=0.0, memory=1e9)


def moving(state, noise=EXACT):
    made = MotionFilter(0.0, HERE, 1.0, 0.0, noise)
    made.state = np.array(state, dtype=float)
    return made


STATES = st.tuples(*(st.floats(-2.0, 2.0) for _ in range(4)), st.floats(-3.0, 3.0))


@settings(max_examples=60, deadline=None)
@given(state=STATES, dt=st.floats(0.001, 2.0))
def test_the_prediction_is_the_arc_that_many_small_steps_make(state, dt):
    made = moving(state)
    made.predict(dt)
    x, y, vx, vy, w = state
    steps = 4000
    h = dt / steps
    angles = math.atan2(vy, vx) + w * (np.arange(steps) + 0.5) * h
    speed = math.hypot(vx, vy)
    end = [x + (speed * np.cos(angles)).sum() * h, y + (speed * np.sin(angles)).sum() * h]
    assert made.state[:2] == pytest.approx(end, abs=1e-5)
    assert math.hypot(*made.state[2:4]) == pytest.approx(speed)


@settings(max_examples=60, deadline=None)
@given(state=STATES, dt=st.floats(0.01, 1.0))
def test_the_covariance_is_carried_by_the_slope_of_the_prediction(state, dt):
    def end(s):
        made = moving(s)
        made.predict(dt)
        return made.state

    size = 1e-6
    columns = [(end(np.array(state) + d) - end(np.array(state) - d)) / (2.0 * size) for d in size * np.eye(5)]
    slope = np.column_stack(columns)
    made = moving(state)
    before = made.covariance = np.diag([0.1, 0.2, 0.3, 0.4, 0.5])
    made.predict(dt)
    assert made.covariance == pytest.approx(slope @ before @ slope.T, abs=1e-4)


def test_a_first_sighting_is_as_sure_as_the_sensor():
    noise = MotionNoise(range=0.1, bearing=0.02)
    made, rng = MotionFilter(0.0, HERE, 3.0, 0.5, noise), np.random.default_rng(1)
    drawn = rng.normal([3.0, 0.5 + HERE.yaw], [0.1, 0.02], (20000, 2))
    points = np.column_stack([drawn[:, 0] * np.cos(drawn[:, 1]), drawn[:, 0] * np.sin(drawn[:, 1])])
    assert made.covariance[:2, :2] == pytest.approx(np.cov(points.T), abs=4e-4)
    assert made.spread == pytest.approx(0.1, rel=0.02)


@pytest.mark.parametrize("twist", [Twist2(0.4), Twist2(0.4, 0.6), Twist2(0.4, -0.6)])
def test_it_finds_speed_and_turn_rate_of_who_drives_an_arc(twist):
    pose, rng = Pose2(1.0, 1.0, 0.5), np.random.default_rng(2)
    made = MotionFilter(0.0, HERE, HERE.distance(pose), HERE.bearing(pose))
    errors, turns = [], []
    for i in range(1, 161):
        pose = along_arc(pose, twist, 0.05)
        distance, bearing = HERE.distance(pose) + rng.normal(0.0, 0.03), HERE.bearing(pose) + rng.normal(0.0, 0.017)
        made.update(0.05 * i, HERE, distance, bearing)
        errors.append(math.hypot(made.state[0] - pose.x, made.state[1] - pose.y))
        turns.append(made.state[4])
    assert np.mean(errors[60:]) < 0.035
    assert math.hypot(*made.state[2:4]) == pytest.approx(twist.forward, abs=0.12)
    # A turn is taken to die away, so what is found of one is too small, but never the wrong way round.
    assert 0.4 <= np.mean(turns[80:]) / twist.turn <= 1.1 if twist.turn else abs(np.mean(turns[80:])) < 0.1


def test_its_errors_are_of_the_size_that_it_says():
    rng, noise, inside = np.random.default_rng(3), MotionNoise(range=0.05, bearing=0.03), []
    for _ in range(60):
        pose, yaw = Pose2(1.0, 1.0, 0.5), rng.uniform(-3.0, 3.0)
        pose = Pose2(1.0, 1.0, yaw)
        made = MotionFilter(0.0, HERE, HERE.distance(pose), HERE.bearing(pose), noise)
        for i in range(1, 61):
            pose = along_arc(pose, Twist2(0.3), 0.05)
            made.update(
                0.05 * i, HERE, HERE.distance(pose) + rng.normal(0.0, 0.05), HERE.bearing(pose) + rng.normal(0.0, 0.03)
            )
        away = made.state[:2] - pose[:2]
        inside.append(away @ np.linalg.inv(made.covariance[:2, :2]) @ away < 5.99)  # 95 % of a chi-square of two
    assert np.mean(inside) > 0.9


def test_time_does_not_go_back_and_who_stands_on_the_observer_teaches_nothing():
    made = MotionFilter(1.0, HERE, 1.0, 0.0)
    before = made.state.copy()
    made.predict(0.5)
    assert (made.t, made.state.tolist()) == (1.0, before.tolist())
    made.update(1.0, Pose2(*before[:2]), 0.5, 1.0)
    assert made.state.tolist() == before.tolist()


def test_without_sightings_it_grows_less_sure_and_a_turn_dies_away():
    made = moving([0.0, 0.0, 0.4, 0.0, 0.5], MotionNoise(memory=1.0))
    spreads = []
    for t in (0.5, 1.0, 2.0, 4.0):
        made.predict(t)
        spreads.append(made.spread)
    assert spreads == sorted(spreads)
    assert made.state[4] == pytest.approx(0.5 * math.exp(-4.0))


NUMBER = st.floats(-3.0, 3.0)
SIGHTINGS = st.lists(st.tuples(st.floats(0.01, 0.5), st.floats(0.3, 4.0), NUMBER, NUMBER, NUMBER, NUMBER), max_size=8)


@settings(max_examples=60, deadline=None)
@given(sightings=SIGHTINGS)
def test_an_update_is_the_textbooks(sightings):
    noise = MotionNoise()
    made = MotionFilter(0.0, HERE, 1.0, 0.2, noise)
    spread = np.diag([noise.range**2, noise.bearing**2])
    for dt, distance, bearing, x, y, yaw in sightings:
        observer = Pose2(x, y, yaw)
        made.predict(made.t + dt)
        state, covariance = made.state, made.covariance
        offset = state[:2] - np.array([x, y])
        expected = float(np.linalg.norm(offset))
        if expected < 0.05:
            return
        slope = np.zeros((2, 5))
        slope[0, :2] = offset / expected
        slope[1, :2] = np.array([-offset[1], offset[0]]) / expected**2
        error = bearing - (math.atan2(offset[1], offset[0]) - yaw)
        innovation = np.array([distance - expected, math.remainder(error, math.tau)])
        gain = covariance @ slope.T @ np.linalg.inv(slope @ covariance @ slope.T + spread)
        made.update(made.t, observer, distance, bearing)
        np.testing.assert_allclose(made.state, state + gain @ innovation, rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(made.covariance, (np.eye(5) - gain @ slope) @ covariance, rtol=1e-7, atol=1e-9)


def test_what_disturbs_the_motion_grows_with_the_time_that_passes():
    noise = MotionNoise(memory=1e9)
    for dt in (0.05, 0.1, 0.05):  # each by itself, whatever was asked before
        made = moving((1.0, 0.0, 0.0, 0.0, 0.0), noise)
        made.covariance = np.zeros((5, 5))
        made.predict(dt)
        assert made.covariance[2, 2] == pytest.approx(noise.acceleration * dt)
        assert made.covariance[0, 0] == pytest.approx(noise.acceleration * dt**3 / 3.0)
        assert made.covariance[4, 4] == pytest.approx(noise.turning * dt)
