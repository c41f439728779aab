"""PeerMonitor: a robot sensor's values as signals."""

import math

import pytest

from rocs_bt.clock import Rate, SimulatedClock
from rocs_bt.control.drive import make_drive
from rocs_bt.drivers.mock import MockRobot, MockSensor, MockWorld
from rocs_bt.errors import InputError
from rocs_bt.event import ListSink, SensorFailed
from rocs_bt.expression import Environment, compile_expression
from rocs_bt.geometry import Pose2
from rocs_bt.knowledge import Knowledge
from rocs_bt.monitor import PeerMonitor, Watched


@pytest.fixture
def made():
    """A monitor with two slots, what feeds it, what it writes to, and what it tells."""
    clock, sink = SimulatedClock(0.05), ListSink()
    knowledge = Knowledge("R3", clock, sink)
    drive = make_drive("differential", track=0.3, max_wheel_speed=1.0, max_wheel_acceleration=1.0)
    knowledge.robot.drive = drive
    sensor = MockSensor("robots", MockRobot(MockWorld(clock), drive, Pose2(0.0, 0.0)))
    monitor = PeerMonitor("peers", [Watched(sensor, Rate(1, 0.05))], knowledge, sink, slots=2)
    for signal in monitor.signals():
        knowledge.signals.declare(signal)
    knowledge.signals.freeze()
    return monitor, sensor, knowledge, sink


def test_each_slot_becomes_tag_range_and_bearing(made):
    monitor, sensor, knowledge, _ = made
    sensor.values = [2.0, 1.2, -0.3, 0.0, math.inf, 0.0]
    monitor.run(0.0, 0)
    read = {name: knowledge.signals.read(name, 0.0).tolist() for name in knowledge.signals.names}
    assert read == {"peer_tag": [2.0, 0.0], "peer_range": [1.2, math.inf], "peer_bearing": [-0.3, 0.0]}
    assert monitor.expects() == {"robots": 6}


def test_rules_may_ask_how_near_anybody_is(made):
    monitor, sensor, knowledge, _ = made
    near = compile_expression("min(peer_range) < 0.5 m", Environment.of(knowledge.signals))
    for values, wanted in (([0.0, math.inf, 0.0] * 2, False), ([2.0, 0.4, 0.1, 0.0, math.inf, 0.0], True)):
        sensor.values = values
        monitor.run(0.0, 0)
        assert bool(near(knowledge.signals.snapshot(0.0).tolist(), 0.0)) is wanted


def test_what_cannot_be_is_nan_and_told(made):
    monitor, sensor, knowledge, sink = made
    sensor.values = [2.0, -1.0, 9.0, 0.0, math.inf, 0.0]
    monitor.run(0.0, 0)
    assert math.isnan(knowledge.signals.read("peer_range", 0.0)[0])
    assert math.isnan(knowledge.signals.read("peer_bearing", 0.0)[0])
    assert [e.sensor for e in sink.events if isinstance(e, SensorFailed)] == ["robots"]


def test_it_needs_a_slot(made):
    with pytest.raises(InputError, match="slots of monitor 'peers' must be at least 1"):
        PeerMonitor("peers", made[0].watched, made[2], made[3], slots=0)
