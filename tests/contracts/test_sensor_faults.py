"""Faults that every shipped robot notices by default: a scanner that repeats itself, and odometry that jumps."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.check.stub_agent import stub_agent
from rocs_bt.event import ListSink, SensorFailed
from rocs_bt.interfaces.device import Reading, Sensor
from rocs_bt.monitor import OdometryMonitor, PoseMonitor, RangeMonitor, ScanMonitor

CATALOG = Catalog()
ROBOTS = [entry.name for entry in CATALOG.list("robot")]
PERIOD, SPEED = 0.05, 0.2  # [s], [m/s]


class Moving(Sensor):
    """Sensor of a robot that drives ahead at SPEED.

    Args:
        name: Name of the sensor.
        signal: Its signal, which says what it measures.
        size: Number of its values.
    """

    def __init__(self, name, signal, size):
        super().__init__(name)
        self.signal, self.size, self.t = signal, size, 0.0
        self.frozen, self.jump = None, np.zeros(size)
        self._noise = np.random.default_rng(1)

    def read(self):
        travel = SPEED * self.t
        values = {"wheel_speeds": np.full(self.size, SPEED), "wheel_travel": np.full(self.size, travel)}
        values |= {"speed": np.array([SPEED, 0.0, 0.0, 0.0])[: self.size], "gyro_rate": np.zeros(self.size)}
        values["pose"] = np.array([travel, 0.0, 0.0] if self.size == 3 else [1e-6 * travel])
        found = values.get(self.signal, 0.9 + self._noise.uniform(0.0, 0.01, self.size))
        return Reading(self.t, (found + self.jump if self.frozen is None else self.frozen).tolist())


class Driving:
    """The monitors of a shipped robot, and its sensors, which all work."""

    def __init__(self, name):
        spec = CATALOG.load_robot(name)
        agent = stub_agent(spec, CATALOG.load_class)
        self.monitors, self.clock, self.sink, self.sensors = agent.monitors, agent.knowledge.clock, ListSink(), {}
        signals = {sensor.name: sensor.signal for sensor in spec.sensors}
        for monitor in self.monitors:
            monitor._sink = self.sink
            for each in monitor.monitored:
                if size := monitor.expects().get(each.sensor.name):
                    each.sensor = Moving(each.sensor.name, signals[each.sensor.name], size)
                    self.sensors[each.sensor.name] = each.sensor

    def of(self, *classes):
        """Sensors that these monitors need."""
        found = [name for m in self.monitors if isinstance(m, classes) for name in m.expects()]
        return [self.sensors[name] for name in found]

    def odometry(self):
        """Position and odometer; the fix of a localiser is none."""
        found = self.of(PoseMonitor, OdometryMonitor)
        return [sensor for sensor in found if sensor.signal in ("pose", "wheel_travel") and sensor.size > 1]

    def drive(self, duration):
        """Drive for a time [s]; details of the faults of the sensors, by name."""
        self.sink.events.clear()
        for _ in range(round(duration / PERIOD)):
            for sensor in self.sensors.values():
                sensor.t = self.clock.now()
            for monitor in self.monitors:
                if monitor.due(self.clock.count):
                    monitor.run(self.clock.now(), self.clock.count)
            self.clock.advance()
        failed = [e for e in self.sink.events if isinstance(e, SensorFailed) and e.sensor in self.sensors]
        return {event.sensor: event.detail for event in failed}


@pytest.mark.parametrize("name", ROBOTS)
def test_a_frozen_scan_is_noticed(name):
    robot = Driving(name)
    ranges = robot.of(ScanMonitor, RangeMonitor)
    assert ranges
    assert robot.drive(1.0) == {}
    for sensor in ranges:
        sensor.frozen = np.array(sensor.read().values)
    found = robot.drive(1.5)
    assert set(found) == {sensor.name for sensor in ranges}
    assert all(detail.startswith("frozen: ") for detail in found.values())


JUMPED = re.compile(r"it jumped by (0\.9\d|1\.0\d) m, faster than the robot can move")


@pytest.mark.parametrize("name", ROBOTS)
def test_a_jump_of_odometry_is_noticed(name):
    """Of 1 m: of each wheel, and of the position in any direction."""
    robot = Driving(name)
    assert robot.drive(2 * PERIOD) == {}
    odometry = robot.odometry()
    assert odometry
    angles = np.linspace(0.0, math.tau, 8, endpoint=False)
    turned = [(*each, 0.0) for each in np.column_stack([np.cos(angles), np.sin(angles)])]
    for sensor in odometry:
        for jump in turned if sensor.signal == "pose" else [*np.eye(sensor.size), *-np.eye(sensor.size)]:
            sensor.jump = np.array(jump)
            found = robot.drive(3 * PERIOD)
            assert set(found) == {sensor.name}
            assert JUMPED.match(found[sensor.name])
            sensor.jump = np.zeros(sensor.size)
            robot.drive(PERIOD)
            assert robot.drive(3 * PERIOD) == {}


@pytest.mark.parametrize("name", ROBOTS)
def test_a_jump_in_the_second_sample_is_noticed(name):
    robot = Driving(name)
    assert robot.drive(PERIOD) == {}
    for sensor in robot.odometry():
        sensor.jump = np.eye(sensor.size)[0]
    found = robot.drive(PERIOD)
    assert set(found) == {sensor.name for sensor in robot.odometry()}
    assert all(map(JUMPED.match, found.values()))
