"""Jumps of a pose: what no motion explains is one, and what a later one undoes is none."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.catalog import SensorSpec
from rocs_bt.declare import Open
from rocs_bt.devices.simulated import declared_keys
from rocs_bt.event import Change, SensorFailed
from rocs_bt.monitor import MotionMonitor, PoseMonitor
from rocs_bt.monitor.jump import FACTOR, JumpDetector

from .test_monitors import Robot

SPEED, SLACK, PERIOD = 0.5, 0.3, 0.05
ANGLES = st.floats(-math.pi, math.pi)


@given(st.lists(st.tuples(st.floats(-1.0, 1.0), st.floats(0.01, 3.0)), max_size=50))
def test_motion_is_never_a_jump(moves):
    """Motions up to the plausible speed, also over gaps between the samples."""
    detector, x, t = JumpDetector(SPEED, SLACK), 0.0, 0.0
    for part, pause in [(0.0, 1.0), *moves]:
        x, t = x + part * FACTOR * SPEED * pause, t + pause
        assert detector.after([x, -2.0], t) == (0.0, 0.0)


@given(st.floats(0.0, 100.0), st.floats(0.4, 1e3), ANGLES, st.integers(0, 50))
def test_a_jump_counts_until_it_is_undone(start, size, direction, samples):
    detector, t = JumpDetector(SPEED, SLACK), PERIOD
    jump = size * math.cos(direction), size * math.sin(direction)
    assert detector.after([start, 0.0], t) == (0.0, 0.0)
    for count in range(samples + 1):  # standing at the wrong place for long makes it no more plausible
        t += PERIOD
        here, total = detector.after([start + jump[0], jump[1]], t)
        assert here == pytest.approx(0.0 if count else size)
        assert total == pytest.approx(size)
    assert detector.after([start, 0.0], t + PERIOD)[1] == 0.0


def test_the_motion_during_many_jumps_that_are_undone_does_not_add_up():
    detector, t = JumpDetector(SPEED, SLACK), 0.0
    for count in range(200):
        t += PERIOD
        wrong = count % 2 == 1
        assert (detector.after([SPEED * t + wrong, 0.0], t)[1] > 0.0) == wrong


@given(ANGLES, st.floats(-0.1, 0.1))
def test_an_angle_may_pass_pi(yaw, turn):
    detector = JumpDetector(1.0, 0.5, math.tau)
    detector.after([yaw], 1.0)
    assert detector.after([math.remainder(yaw + turn, math.tau)], 1.05) == (0.0, 0.0)
    assert detector.after([math.remainder(yaw + turn + 2.0, math.tau)], 1.1)[1] == pytest.approx(2.0)


@pytest.mark.parametrize("frame", ["continuous", "corrected", ""])
def test_a_jump_is_invalid_or_an_event(frame):
    robot = Robot()
    position, orientation = robot.sensor("position", 3), robot.sensor("orientation", 1)
    robot.watch(PoseMonitor, position, orientation, frame=frame)
    robot.begin()
    position.values, orientation.values = [0.0, 0.0, 0.0], [0.0]
    robot.step(3)
    position.values = [1.0, 0.0, 0.0]
    robot.step(60)
    assert math.isnan(robot.read("pose")[0]) == (frame == "continuous")
    assert [event.kind for event in robot.of(Change)] == (["jumped"] if frame == "corrected" else [])
    failed = [event.detail for event in robot.of(SensorFailed)]
    assert failed == (["it jumped by 1.00 m, faster than the robot can move"] if frame == "continuous" else [])
    position.values = [0.0, 0.0, 0.0]
    robot.step(3)
    assert robot.read("pose") == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("frame", ["continuous", "corrected", ""])
def test_a_jump_of_the_height_is_invalid_in_a_continuous_frame(frame):
    robot = Robot()
    height = robot.sensor("height", 1)
    robot.watch(MotionMonitor, height, frame=frame)
    robot.begin()
    robot.step(1)
    height.values = [1.0]
    robot.step(3)
    assert math.isnan(robot.read("height")[0]) == (frame == "continuous")
    height.values = [0.0]
    robot.step(1)
    assert robot.read("height") == [0.0]


@pytest.mark.parametrize(
    ("driver", "parameters", "frame"),
    [
        ("ros2", {"type": "nav_msgs/msg/Odometry"}, "continuous"),
        ("ros2", {"type": "geometry_msgs/msg/PoseWithCovarianceStamped"}, "corrected"),
        ("ros2", {"type": "tf2_msgs/msg/TFMessage"}, "corrected"),
        ("ros2", {"type": "tf2_msgs/msg/TFMessage", "frame": "r2/odom"}, "continuous"),
        ("udp.py:Position", {}, "continuous"),
        ("position", {}, "continuous"),
        ("orientation", {}, ""),
    ],
)
def test_the_driver_tells_the_frame(driver, parameters, frame):
    declared = declared_keys(driver, "sensor")
    given = Open(parameters) if declared is None else declared(**parameters)
    assert SensorSpec(name="position", driver=driver, monitor="pose", parameters=given).frame == frame
