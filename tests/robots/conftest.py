"""A robot with three beams and the SUMMIT-XL's SurroundMonitor."""

import math

import pytest

from rocs_bt.base.clock import Rate, SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import ANGLE, LENGTH, SPEED, TURN_RATE
from rocs_bt.control.locomotion_kinds import Braking, make_locomotion
from rocs_bt.event import ListSink
from rocs_bt.interfaces.device import Reading, Sensor
from rocs_bt.knowledge import Knowledge
from rocs_bt.monitor import MonitoredSensor
from rocs_bt.monitor.range_monitor import GroupTable

from .summit_xl import surround_monitor

NONE = [math.inf] * 3
GROUPS = {
    "front": GroupTable(beams=(0, 1, 2)),
    "left_gap": GroupTable(beams=(0,)),
    "right_gap": GroupTable(beams=(2,)),
    "rear": GroupTable(blind=True),
}
GIVEN = {
    "beams": 3,
    "group": GROUPS,
    "mounts": [(0.3, 0.1, 0.6), (0.3, 0.0, 0.0), (0.3, -0.1, -0.6)],
    "half_angle": 0.26,
    "max_range": 1.0,
    "max_echo_age": 10.0,
    "max_free_ground_age": 10.0,
    "peer_radius": 0.25,
}


class Ranges(Sensor):
    """Says what the test wants."""

    def __init__(self, clock):
        super().__init__("ranges")
        self.clock, self.values = clock, NONE

    def read(self):
        return Reading(self.clock.now(), list(self.values))


class Rig:
    """A robot of 0.7 x 0.6 m at the origin, and one peer wherever a test puts it."""

    def __init__(self, **given):
        self.clock = SimulatedClock(0.05)
        self.knowledge = Knowledge("R3", self.clock, ListSink())
        self.knowledge.robot.locomotion = make_locomotion(
            "differential",
            wheel_separation=0.6,
            max_wheel_speed=2.0,
            max_wheel_acceleration=1.5,
            latency=0.1,
            vx=Braking(deceleration=2.0),
        )
        self.knowledge.graph.set("R3", length=0.7, width=0.6)
        self.sensor, self.count = Ranges(self.clock), 0
        watched = [MonitoredSensor(self.sensor, Rate(1, 0.05))]
        self.monitor = surround_monitor.SurroundMonitor(
            "range", watched, self.knowledge, ListSink(), **{**GIVEN, **given}
        )
        declared = [
            Signal("pose", 3, (LENGTH, LENGTH, ANGLE)),
            Signal("speed", 1, (SPEED,)),
            Signal("turn_rate", 1, (TURN_RATE,)),
            Signal("peer_range", 2, (LENGTH,)),
        ]
        for signal in [*self.monitor.signals(), *declared]:
            self.knowledge.signals.declare(signal)
        self.knowledge.signals.freeze()
        self.peers(math.inf, math.inf)
        self.at(Pose2(0.0, 0.0, 0.0))

    def at(self, pose, speed=0.0, turn=0.0):
        for name, values in (("pose", pose), ("speed", [speed]), ("turn_rate", [turn])):
            self.knowledge.signals.write(name, values, self.clock.now())

    def peers(self, *ranges):
        self.knowledge.signals.write("peer_range", ranges, self.clock.now())

    def peer(self, pose, speed=0.0, name="R1"):
        if not self.knowledge.graph.has(name):
            self.knowledge.graph.add(name, "peer", tag=1)
        self.knowledge.graph.set(name, pose=pose, speed=speed, turn_rate=0.0)

    def groups(self, values=NONE):
        self.sensor.values = values
        self.monitor.run(self.clock.now(), self.count)
        read = {name: self.knowledge.signals.read(name, self.clock.now()).min() for name in GROUPS}
        self.count += 1
        self.clock.advance()
        return read

    def look_round(self, pose):
        """Turn once about, where nothing is."""
        for i in range(25):
            self.at(pose._replace(yaw=pose.yaw + 0.25 * i))
            self.groups()
        self.at(pose)

    def wait(self, duration):
        for _ in range(round(duration / 0.05)):
            self.clock.advance()
        self.peers(math.inf, math.inf)
        self.at(Pose2(0.0, 0.0, 0.0))

    def room(self, name):
        return self.knowledge.signals.read(name, self.clock.now() - 0.05).tolist()


@pytest.fixture
def surround():
    """Makes such a robot, of other parameters."""
    return Rig


@pytest.fixture
def rig():
    return Rig()
