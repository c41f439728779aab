"""Signals of motion in any direction: course speed and range, lateral speed, climb, tilt and height."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocs_bt.base.clock import Rate, SimulatedClock
from rocs_bt.base.errors import InputError
from rocs_bt.base.geometry import Pose2, Twist2
from rocs_bt.control.locomotion_kinds import Axis, Braking, TurnAxis, make_locomotion
from rocs_bt.event import ListSink
from rocs_bt.interfaces.device import Reading, Sensor
from rocs_bt.knowledge import Knowledge
from rocs_bt.monitor import MonitoredSensor, MotionMonitor, RangeMonitor, ScanMonitor, WheelMonitor
from rocs_bt.monitor.course import course_range

LIMITS = {"max_wheel_speed": 1.0, "max_wheel_acceleration": 1.0}
BRAKING = {"vx": 2.0, "vy": 1.0, "vz": 4.0}
AXES = {axis: Axis(max_speed=1.0, max_acceleration=1.0, deceleration=each) for axis, each in BRAKING.items()}
AXES["wz"] = TurnAxis(max_speed=1.0, max_acceleration=1.0)
WHEELS = {"kind": "differential", "wheel_separation": 0.3, "vx": Braking(deceleration=2.0), **LIMITS}
MECANUM = {"kind": "mecanum", "half_length": 0.1, "half_width": 0.1, **LIMITS}
MECANUM |= {axis: Braking(deceleration=BRAKING[axis]) for axis in ("vx", "vy")}
FLYING = {"kind": "flying", **AXES}
LEGGED = {"kind": "legged", "vx": AXES["vx"], "wz": AXES["wz"]}


class Given(Sensor):
    """Sensor with given values."""

    def __init__(self, name: str, values: list[float]) -> None:
        super().__init__(name)
        self.values = values

    def read(self) -> Reading:
        return Reading(0.0, self.values)


def robot(locomotion: dict[str, Any]) -> Knowledge:
    knowledge = Knowledge("R", SimulatedClock(0.05), ListSink())
    knowledge.graph.set("R", length=0.4, width=0.4)
    knowledge.robot.locomotion = make_locomotion(**locomotion)
    return knowledge


def monitor(cls: type, knowledge: Knowledge, sensors: dict[str, list[float]], **more: Any) -> Any:
    watched = [MonitoredSensor(Given(name, values), Rate(1, 0.05)) for name, values in sensors.items()]
    made = cls("m", watched, knowledge, ListSink(), **more)
    for signal in made.signals():
        knowledge.signals.declare(signal)
    return made


def written(made: Any, knowledge: Knowledge) -> dict[str, Any]:
    made.run(0.0, 0)
    return {signal.name: knowledge.signals.read(signal.name, 0.0).tolist() for signal in made.signals()}


def test_wheels_write_the_course_only_if_they_can_move_sideways():
    knowledge = robot(MECANUM)
    twist = Twist2(0.3, 0.5, -0.4)
    values = knowledge.robot.locomotion.command(twist).tolist()
    found = written(monitor(WheelMonitor, knowledge, {"encoders": values}), knowledge)
    assert found["speed"] == pytest.approx([0.3])
    assert found["lateral_speed"] == pytest.approx([-0.4])
    assert found["course_speed"] == pytest.approx([0.5])
    assert found["stop_distance"] == pytest.approx([0.5 * 0.1 + 0.5 * (0.3 / 4.0 + 0.4 / 2.0)])
    wheels = robot(WHEELS)
    found = written(monitor(WheelMonitor, wheels, {"encoders": [0.3, 0.5]}), wheels)
    assert list(found) == ["wheel_speeds", "speed", "turn_rate", "stop_distance"]
    assert found["stop_distance"] == [0.4 * 0.1 + 0.4 * 0.4 / 4.0]


def test_a_body_without_wheels_writes_what_its_axes_and_sensors_give():
    sensors = {"twist": [0.3, -0.4, 1.2, 0.5], "attitude": [0.3, -0.4], "height": [1.5]}
    knowledge = robot(FLYING)
    found = written(monitor(MotionMonitor, knowledge, sensors), knowledge)
    assert found["stop_distance"] == pytest.approx([1.3 * 0.1 + 1.3 * max(0.3 / 4.0, 0.4 / 2.0, 1.2 / 8.0)])
    assert found["tilt"] == pytest.approx([math.acos(math.cos(0.3) * math.cos(0.4))])
    rest = {name: found[name] for name in found if name not in ("stop_distance", "tilt")}
    assert rest == {
        "speed": [0.3],
        "turn_rate": [0.5],
        "course_speed": pytest.approx([1.3]),
        "lateral_speed": [-0.4],
        "climb": [1.2],
        "height": [1.5],
    }
    legs = robot(LEGGED)
    found = written(monitor(MotionMonitor, legs, {"twist": [0.3, 0.1, 0.1, 0.5]}), legs)
    assert list(found) == ["speed", "turn_rate", "stop_distance"]
    assert found["stop_distance"] == pytest.approx([0.3 * 0.1 + 0.3**2 / 4.0])  # its body bobs as it walks


def test_tilt_alone_on_a_robot_with_wheels_and_wrong_sensors():
    wheels = robot(WHEELS)
    found = written(monitor(MotionMonitor, wheels, {"imu": [0.1, 0.0]}, attitude="imu"), wheels)
    assert found == {"tilt": pytest.approx([0.1])}
    with pytest.raises(InputError, match="needs a sensor 'twist', 'attitude' or 'height', found gyro"):
        monitor(MotionMonitor, robot(WHEELS), {"gyro": [0.0]})


def test_invalid_readings_are_nan():
    knowledge = robot(FLYING)
    found = written(monitor(MotionMonitor, knowledge, {"twist": [0.3, math.nan, 0.0, 0.0]}), knowledge)
    assert found["speed"] == [0.3]
    assert all(math.isnan(found[name][0]) for name in ("lateral_speed", "course_speed", "stop_distance"))
    knowledge = robot(FLYING)
    found = written(monitor(MotionMonitor, knowledge, {"twist": [0.3, math.inf, 0.0, 0.0]}), knowledge)
    assert all(math.isnan(value) for (value,) in found.values())


BEARINGS = np.radians(np.arange(-180.0, 180.0, 10.0))


@given(st.integers(-18, 17), st.floats(0.1, 2.0), st.floats(0.03, 1.0))
def test_the_course_range_is_that_of_front_in_any_direction(k, gap, speed):
    """An obstacle on the course counts in full, one beside it as farther, and one beyond 60 deg not at all."""
    course = math.radians(10.0 * k)
    twist = Twist2(speed * math.cos(course), 0.3, speed * math.sin(course))
    for away, weight in ((0, 1.0), (1, 1.0), (-3, 0.85), (4, 0.725), (-5, 0.6), (6, 0.6)):
        ranges = np.full(36, math.inf)
        ranges[(k + 18 + away) % 36] = gap
        assert course_range(BEARINGS, ranges, twist) == pytest.approx(gap / weight)
    ranges = np.full(36, math.inf)
    ranges[(k + 18 + 7) % 36] = ranges[(k + 18 - 7) % 36] = gap
    assert course_range(BEARINGS, ranges, twist) == math.inf


def test_the_course_range_of_a_stationary_robot_and_of_unknown_values():
    ranges = np.full(36, 0.2)
    assert course_range(BEARINGS, ranges, Twist2(0.01, 1.0, 0.015)) == math.inf
    assert math.isnan(course_range(BEARINGS, ranges, Twist2(math.nan, 0.0, 0.0)))
    ranges[18] = math.nan
    assert math.isnan(course_range(BEARINGS, ranges, Twist2(0.3, 0.0, 0.0)))
    assert course_range(BEARINGS, ranges, Twist2(-0.3, 0.0, 0.0)) == pytest.approx(0.2)
    assert course_range(BEARINGS[:1], ranges[:1], Twist2(0.3, 0.0, 0.0)) == math.inf  # no beam in this direction


@pytest.mark.parametrize("kind", ["ring", "scan"])
@pytest.mark.parametrize("locomotion", [MECANUM, WHEELS], ids=["mecanum", "differential"])
def test_the_monitors_of_ranges_write_it_for_robots_that_move_sideways(kind, locomotion):
    knowledge = robot(locomotion)
    wheels = {"encoders": knowledge.robot.locomotion.command(Twist2(0.0, 0.0, 0.5)).tolist()}
    motion = monitor(WheelMonitor, knowledge, wheels)
    if kind == "ring":
        bearings = [math.radians(angle) for angle in (0.0, 90.0, 180.0, -90.0)]
        ranges = monitor(RangeMonitor, knowledge, {"sonar": [0.2, 0.5, 0.3, 0.1]}, beams=4, bearings=bearings)
    else:  # behind the middle, and looking back; rays from the right to the left, first and last ahead
        mount = Pose2(0.0, 0.0, math.pi)
        attributes = {"signal": "scan", "rays": 5, "span": math.tau, "mount": mount}
        knowledge.graph.add("lidar", "sensor", **attributes)
        knowledge.graph.relate("R", "has_sensor", "lidar")
        ranges = monitor(ScanMonitor, knowledge, {"lidar": [0.4, 0.7, 0.5, 0.3, 0.4]})
    assert ("course_range" in [signal.name for signal in ranges.signals()]) == (locomotion is MECANUM)
    if locomotion is MECANUM:
        assert math.isnan(written(ranges, knowledge)["course_range"][0])  # the motion is not known yet
        written(motion, knowledge)
        assert written(ranges, knowledge)["course_range"] == pytest.approx([0.5])


def test_wrong_bearings():
    with pytest.raises(InputError, match="bearings of monitor 'm' must be one angle per beam, found 3 for 4 beams"):
        monitor(RangeMonitor, robot(MECANUM), {"sonar": [1.0] * 4}, beams=4, bearings=[0.0, 1.0, 2.0])
    knowledge = robot(MECANUM)
    assert len(monitor(RangeMonitor, knowledge, {"sonar": [1.0] * 4}, beams=4).signals()) == 1
