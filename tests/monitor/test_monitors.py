"""Monitors: what sensors say becomes signals; what they do not say becomes NaN."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.clock import Rate, SimulatedClock
from rocs_bt.control.drive import make_drive
from rocs_bt.device import Reading, Sensor
from rocs_bt.errors import DeviceError, InputError, WiringError
from rocs_bt.event import ListSink, SensorFailed, SensorRead, SignalsWritten
from rocs_bt.geometry import Pose2
from rocs_bt.knowledge import Knowledge
from rocs_bt.monitor import Monitor, PoseMonitor, RangeMonitor, Watched, WheelMonitor
from rocs_bt.signal import Signal

PERIOD = 0.05


class Scripted(Sensor):
    """A sensor that says what the test wants; an exception is raised, a stamp may be old."""

    def __init__(self, name, clock, size):
        super().__init__(name)
        self.clock = clock
        self.values = [0.0] * size
        self.stamp = None

    def read(self):
        if isinstance(self.values, Exception):
            raise self.values
        return Reading(self.clock.now() if self.stamp is None else self.stamp, list(self.values))


class Robot:
    """A Knowledge, a clock, and whatever monitors a test adds."""

    def __init__(self):
        self.clock = SimulatedClock(PERIOD)
        self.sink = ListSink()
        self.knowledge = Knowledge("R2", self.clock, self.sink)
        self.knowledge.robot.drive = make_drive(
            "differential", track=0.33, max_wheel_speed=1.2, max_wheel_acceleration=1.5
        )
        self.monitors = []

    def sensor(self, name, size):
        return Scripted(name, self.clock, size)

    def watch(self, cls, *sensors, every=1, **parameters):
        watched = [Watched(s, Rate(every, PERIOD)) for s in sensors]
        monitor = cls(f"{sensors[0].name} monitor", watched, self.knowledge, self.sink, **parameters)
        self.monitors.append(monitor)
        return monitor

    def begin(self):
        for monitor in self.monitors:
            for signal in monitor.signals():
                self.knowledge.signals.declare(signal)
        self.knowledge.signals.freeze()

    def step(self, count=1):
        for _ in range(count):
            for monitor in self.monitors:
                if monitor.due(self.clock.count):
                    monitor.run(self.clock.now(), self.clock.count)
            self.clock.advance()

    def read(self, name):
        return self.knowledge.signals.read(name, self.clock.now()).tolist()

    def of(self, kind):
        return [e for e in self.sink.events if isinstance(e, kind)]


@pytest.fixture
def robot():
    return Robot()


@pytest.fixture
def wheels(robot):
    sensor = robot.sensor("wheels", 2)
    robot.watch(WheelMonitor, sensor, latency=0.1)
    return sensor


@pytest.fixture
def sonar(robot, wheels):
    sensor = robot.sensor("sonar", 4)
    groups = {"front": {"beams": [1, 2], "weights": [0.5, 1.0]}, "rear": {"beams": [3]}}
    robot.watch(RangeMonitor, sensor, beams=4, group=groups, frozen_after=0.5)
    robot.begin()
    return sensor


def test_groups_are_equivalent_frontal_distances(robot, sonar):
    sonar.values = [0.9, 0.4, 0.7, math.inf]
    robot.step()
    assert robot.read("sonar") == [0.9, 0.4, 0.7, math.inf]
    assert robot.read("front") == [0.8, 0.7]
    assert robot.read("rear") == [math.inf]
    written = robot.of(SignalsWritten)[-1]
    assert written.values["front"] == [0.8, 0.7]
    assert robot.of(SensorRead)[-1].values == sonar.values


def test_where_a_robot_looks_nowhere_is_never_an_echo(robot, wheels):
    sonar = robot.sensor("sonar", 1)
    robot.watch(RangeMonitor, sonar, beams=1, group={"front": {"beams": [0]}, "rear": {"blind": True}})
    robot.begin()
    sonar.values = [0.2]
    robot.step()
    assert (robot.read("front"), robot.read("rear")) == ([0.2], [math.inf])
    sonar.values = DeviceError("unplugged")
    robot.step(4)
    assert np.isnan([*robot.read("front"), *robot.read("rear")]).all(), "no news is no promise"


def test_a_broken_beam_breaks_its_groups_and_no_other(robot, sonar):
    sonar.values = [0.9, math.nan, 0.7, 1.0]
    robot.step()
    assert np.isnan(robot.read("front")[0])
    assert robot.read("rear") == [1.0]


@pytest.mark.parametrize(
    ("group", "message"),
    [
        ({"beams": [4]}, "must list beams between 0 and 3"),
        (
            {"beams": []},
            "must list beams between 0 and 3, found []. If the robot looks nowhere there, write blind = true",
        ),
        ({}, "write blind = true"),
        ({"beams": [], "blind": False}, "must list beams"),
        ({"beams": [1], "blind": True}, "is blind, but has beams [1]"),
        ({"beams": [0, 1], "weights": [1.0]}, "one weight in (0, 1] for each beam"),
        ({"beams": [0], "weights": [0.0]}, "one weight in (0, 1] for each beam"),
    ],
)
def test_a_group_that_cannot_be_is_refused(robot, group, message):
    with pytest.raises(InputError) as error:
        robot.watch(RangeMonitor, robot.sensor("sonar", 4), beams=4, group={"front": group})
    assert message in str(error.value)


@pytest.mark.parametrize(("beams", "bound"), [(0, "at least 1"), (1001, "at most 1000"), (10**8, "at most 1000")])
def test_a_number_of_beams_that_cannot_be_is_refused(robot, beams, bound):
    with pytest.raises(InputError, match=f"beams of monitor 'sonar monitor' must be {bound}, found {beams}"):
        robot.watch(RangeMonitor, robot.sensor("sonar", 4), beams=beams)


def test_a_sensor_that_refuses_goes_stale_and_is_told_once(robot, sonar):
    sonar.values = [1.0] * 4
    robot.step(3)
    sonar.values = DeviceError("no answer from the bus")
    robot.step(2)
    assert robot.read("front") == [2.0, 1.0], "still within three periods"
    robot.step(2)
    assert np.isnan(robot.read("front")).all()
    assert [e.detail for e in robot.of(SensorFailed)] == ["no answer from the bus"]
    sonar.values = [1.0] * 4
    robot.step()
    assert robot.read("front") == [2.0, 1.0], "it came back"


def test_a_device_that_repeats_an_old_sample_goes_stale(robot, sonar):
    robot.step()
    sonar.stamp = robot.clock.now() - PERIOD
    robot.step(4)
    assert np.isnan(robot.read("front")).all()


def test_values_that_freeze_while_the_wheels_turn_are_broken(robot, sonar, wheels):
    sonar.values = [0.9, 0.8, 0.7, math.inf]
    robot.step(20)
    assert robot.of(SensorFailed) == [], "at rest nothing need change"
    wheels.values = [0.3, 0.3]
    robot.step(14)
    assert np.isnan(robot.read("front")).all()
    assert "frozen" in robot.of(SensorFailed)[0].detail
    sonar.values = [0.9, 0.8, 0.7, 0.65]
    robot.step()
    assert robot.read("rear") == [0.65]


def test_hearing_no_echo_for_long_is_not_frozen(robot, sonar, wheels):
    sonar.values, wheels.values = [math.inf] * 4, [0.3, 0.3]
    robot.step(100)
    assert robot.of(SensorFailed) == []


@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))
def test_wheels_tell_speed_turn_rate_and_stop_distance(left, right):
    robot = Robot()
    sensor = robot.sensor("wheels", 2)
    robot.watch(WheelMonitor, sensor, latency=0.1)
    robot.begin()
    sensor.values = [left, right]
    robot.step()
    speed = (left + right) / 2
    assert robot.knowledge.robot.speed() == pytest.approx(speed)
    assert robot.knowledge.robot.turn_rate() == pytest.approx((right - left) / 0.33)
    (stop,) = robot.read("stop_distance")
    assert stop == pytest.approx(abs(speed) * 0.1 + speed**2 / 3.0)


def test_a_measured_deceleration_takes_the_place_of_the_drives(robot):
    sensor = robot.sensor("wheels", 2)
    robot.watch(WheelMonitor, sensor, latency=0.05, deceleration=3.0)
    robot.begin()
    sensor.values = [0.6, 0.6]
    robot.step()
    assert robot.read("stop_distance") == pytest.approx([0.6 * 0.05 + 0.6**2 / 6.0])


@pytest.mark.parametrize("wrong", [{"latency": -0.1}, {"deceleration": 0.0}, {"latency": math.nan}])
def test_wheels_that_cannot_brake_are_refused(robot, wrong):
    with pytest.raises(InputError, match="a latency of 0 s or more and a deceleration above 0"):
        robot.watch(WheelMonitor, robot.sensor("wheels", 2), **wrong)


@pytest.fixture
def pose(robot):
    position, orientation = robot.sensor("position", 3), robot.sensor("orientation", 1)
    robot.watch(PoseMonitor, position, orientation)
    robot.begin()
    return position, orientation


def test_pose_and_goal_distance(robot, pose):
    position, orientation = pose
    position.values, orientation.values = [3.0, 4.0, 0.1], [3.0 * math.pi]
    robot.step()
    assert robot.knowledge.robot.pose() == pytest.approx((3.0, 4.0, math.pi))
    assert robot.read("goal_distance") == [math.inf]
    robot.knowledge.world.place("dock", Pose2(0.0, 0.0), kind="goal")
    robot.knowledge.world.pursue("dock")
    robot.step()
    assert robot.read("goal_distance") == pytest.approx([5.0])


def test_half_a_pose_is_no_pose(robot, pose):
    position, _ = pose
    position.values = DeviceError("gone")
    robot.step()
    assert math.isnan(robot.knowledge.robot.pose().x)


def test_a_slow_sensor_is_read_at_its_own_rate(robot):
    sensor = robot.sensor("wheels", 2)
    robot.watch(WheelMonitor, sensor, every=4)
    robot.begin()
    robot.step(12)
    assert [e.t for e in robot.of(SensorRead)] == pytest.approx([0.0, 0.2, 0.4])


def test_a_monitor_attaches_to_an_analyze_only(robot, wheels):
    with pytest.raises(WiringError, match="can be attached to an Analyze only"):
        robot.monitors[0].attach(robot.monitors[0])


def test_a_users_monitor_needs_two_methods(robot):
    class Battery(Monitor):
        def signals(self):
            return [Signal("charge", 1, bounds=(0.0, 1.0), max_age=self.max_age)]

        def interpret(self, readings):
            return {"charge": [(readings["voltage"].values[0] - 11.0) / 2.0]}

    sensor = robot.sensor("voltage", 1)
    robot.watch(Battery, sensor)
    robot.begin()
    sensor.values = [12.5]
    robot.step()
    assert robot.read("charge") == [0.75]
