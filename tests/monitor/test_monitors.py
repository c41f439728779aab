"""Monitors: what sensors say becomes signals; what they do not say becomes NaN."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.clock import Rate, SimulatedClock
from rocs_bt.base.errors import DeviceError, InputError, WiringError
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.signal import Signal
from rocs_bt.control.locomotion_kinds import Axis, TurnAxis, make_locomotion
from rocs_bt.event import ListSink, SensorFailed, SensorRead, SignalsWritten
from rocs_bt.interfaces.device import Reading, Sensor
from rocs_bt.interfaces.message import ReceivedMessage, packed
from rocs_bt.knowledge import Knowledge
from rocs_bt.monitor import (
    FixMonitor,
    MessageMonitor,
    Monitor,
    MonitoredSensor,
    OdometryMonitor,
    PeerMonitor,
    PoseMonitor,
    RangeMonitor,
    WheelMonitor,
)
from rocs_bt.monitor.range_monitor import GroupTable

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
        self.knowledge.robot.locomotion = make_locomotion(
            "differential", wheel_separation=0.33, max_wheel_speed=1.2, max_wheel_acceleration=1.5
        )
        self.monitors = []

    def sensor(self, name, size):
        return Scripted(name, self.clock, size)

    def watch(self, cls, *sensors, every=1, frame="", **parameters):
        watched = [MonitoredSensor(s, Rate(every, PERIOD), frame=frame) for s in sensors]
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
    robot.watch(WheelMonitor, sensor)
    return sensor


@pytest.fixture
def sonar(robot, wheels):
    sensor = robot.sensor("sonar", 4)
    groups = {"front": {"beams": [1, 2], "weights": [0.5, 1.0]}, "rear": {"beams": [3]}}
    robot.watch(RangeMonitor, sensor, beams=4, group={n: GroupTable(**g) for n, g in groups.items()}, frozen_after=0.5)
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
    robot.watch(RangeMonitor, sonar, beams=1, group={"front": GroupTable(beams=[0]), "rear": GroupTable(blind=True)})
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
            "must list beams between 0 and 3, found []. If the robot has no sensor in this direction, write blind =",
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
        robot.watch(RangeMonitor, robot.sensor("sonar", 4), beams=4, group={"front": GroupTable(**group)})
    assert message in str(error.value)


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


@pytest.mark.parametrize("repeats", [True, False])
def test_a_scan_that_repeats_with_fresh_stamps_is_frozen_but_a_slow_one_is_not(robot, sonar, wheels, repeats):
    """A sensor of 1 Hz that is read at 20 Hz gives each sample twenty times, with the same stamp."""
    wheels.values = [0.5, 0.5]
    for count in range(4):
        sonar.values = [1.0, 1.0, 2.0, 2.0 + (0.0 if repeats else 0.001 * count)]
        sonar.stamp = robot.clock.now()
        for _ in range(20):
            sonar.stamp = robot.clock.now() if repeats else sonar.stamp
            robot.step()
    assert any("frozen" in event.detail for event in robot.of(SensorFailed)) == repeats


def test_hearing_no_echo_for_long_is_not_frozen(robot, sonar, wheels):
    sonar.values, wheels.values = [math.inf] * 4, [0.3, 0.3]
    robot.step(100)
    assert robot.of(SensorFailed) == []


@given(st.floats(-1.2, 1.2), st.floats(-1.2, 1.2))
def test_wheels_tell_speed_turn_rate_and_stop_distance(left, right):
    robot = Robot()
    sensor = robot.sensor("wheels", 2)
    robot.watch(WheelMonitor, sensor)
    robot.begin()
    sensor.values = [left, right]
    robot.step()
    speed = (left + right) / 2
    assert robot.knowledge.robot.speed() == pytest.approx(speed)
    assert robot.knowledge.robot.turn_rate() == pytest.approx((right - left) / 0.33)
    (stop,) = robot.read("stop_distance")
    assert stop == pytest.approx(abs(speed) * 0.1 + speed**2 / 3.0)


def test_a_body_without_wheels_has_no_wheel_monitor(robot):
    axes = {"vx": Axis(max_speed=1.0, max_acceleration=1.0), "wz": TurnAxis(max_speed=1.0, max_acceleration=1.0)}
    robot.knowledge.robot.locomotion = make_locomotion("twist", **axes)
    with pytest.raises(InputError, match="a 'twist' locomotion has no wheels"):
        robot.watch(WheelMonitor, robot.sensor("wheels", 2))


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


@pytest.fixture
def odometry(robot):
    sensors = robot.sensor("odometer", 2), robot.sensor("gyro", 1)
    robot.watch(OdometryMonitor, *sensors)
    robot.begin()
    return sensors


@pytest.fixture
def fixes(robot):
    sensors = robot.sensor("position", 3), robot.sensor("orientation", 1)
    robot.watch(FixMonitor, *sensors, every=10)
    robot.begin()
    return sensors


def test_a_gyro_is_there_or_not(robot, odometry):
    odometry[0].values, odometry[1].values = [1.0, 2.0], [0.3]
    robot.step()
    assert (robot.read("wheel_travel"), robot.read("gyro_rate")) == ([1.0, 2.0], [0.3])
    assert robot.monitors[0].expects() == {"odometer": 2, "gyro": 1}
    other = Robot()
    without = other.watch(OdometryMonitor, other.sensor("odometer", 2))
    assert [signal.name for signal in without.signals()] == ["wheel_travel"]
    assert without.expects() == {"odometer": 2}


@pytest.mark.parametrize(
    ("sensors", "silent", "heard"), [("odometry", 1, "wheel_travel"), ("fixes", 0, "compass"), ("fixes", 1, "fix")]
)
def test_one_that_refuses_does_not_silence_the_other(robot, request, sensors, silent, heard):
    sensor = request.getfixturevalue(sensors)[silent]
    sensor.values = DeviceError("no")
    robot.step()
    assert not any(robot.read(heard))
    assert [e.sensor for e in robot.of(SensorFailed)] == [sensor.name]


@pytest.mark.parametrize(("sensors", "signal"), [("odometry", "wheel_travel"), ("fixes", "fix")])
def test_infinity_is_no_place_and_no_way(robot, request, sensors, signal):
    sensor = request.getfixturevalue(sensors)[0]
    sensor.values = [math.inf] * len(sensor.values)
    robot.step()
    assert all(map(math.isnan, robot.read(signal)))


def test_fixes_are_slow_and_stay_valid_for_three_of_their_periods(robot, fixes):
    fixes[0].values, fixes[1].values = [1.0, 2.0, 0.1], [4.0]
    robot.step()
    assert (robot.read("fix"), robot.read("compass")) == ([1.0, 2.0], [pytest.approx(4.0 - math.tau)])
    fixes[0].values = [7.0] * 3
    robot.step()
    assert robot.read("fix") == [1.0, 2.0], "it is not read between"
    assert robot.monitors[0].max_age == pytest.approx(1.5)


@pytest.fixture
def peers(robot, wheels):
    sensor = robot.sensor("robots", 6)
    robot.watch(PeerMonitor, sensor, max_peers=2)
    robot.begin()
    return sensor


def test_each_slot_becomes_tag_range_and_bearing(robot, peers):
    peers.values = [2.0, 1.2, -0.3, 0.0, math.inf, 0.0]
    robot.step()
    found = [robot.read(name) for name in ("peer_tag", "peer_range", "peer_bearing")]
    assert found == [[2.0, 0.0], [1.2, math.inf], [-0.3, 0.0]]
    assert robot.monitors[1].expects() == {"robots": 6}


def test_a_peer_that_cannot_be_is_nan_and_told(robot, peers):
    peers.values = [2.0, -1.0, 9.0, 0.0, math.inf, 0.0]
    robot.step()
    assert math.isnan(robot.read("peer_range")[0])
    assert math.isnan(robot.read("peer_bearing")[0])
    assert [e.sensor for e in robot.of(SensorFailed)] == ["robots"]


@pytest.mark.parametrize("kept", [1, 3])
def test_the_newest_messages_are_nodes_and_all_are_counted(robot, kept):
    inbox = robot.sensor("inbox", 0)
    robot.watch(MessageMonitor, inbox, max_messages=kept)
    robot.begin()
    graph = robot.knowledge.graph
    for numbers in ([1, 2], [3], [], [4, 5]):
        inbox.values = packed(ReceivedMessage("R1", f"text {n}") for n in numbers)
        robot.step()
    assert robot.read("messages") == [5.0]
    newest = [5, 4, 3][:kept]
    assert sorted(graph.nodes("message"), reverse=True) == [f"message {n}" for n in newest]
    for n in newest:
        node = graph.attributes(f"message {n}")
        assert (node["sender"], node["text"], node["number"]) == ("R1", f"text {n}", n)
