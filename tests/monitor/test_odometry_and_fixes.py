"""OdometryMonitor and FixMonitor: raw numbers for a localisation, each when its sensor speaks."""

import math

import pytest

from rocs_bt.clock import Rate, SimulatedClock
from rocs_bt.control.drive import make_drive
from rocs_bt.device import Reading, Sensor
from rocs_bt.errors import DeviceError
from rocs_bt.event import ListSink, SensorFailed
from rocs_bt.knowledge import Knowledge
from rocs_bt.monitor import FixMonitor, OdometryMonitor, Watched

PERIOD = 0.05


class Scripted(Sensor):
    """Says what the test wants; None refuses."""

    def __init__(self, name, clock):
        super().__init__(name)
        self.clock, self.values = clock, None

    def read(self):
        if self.values is None:
            raise DeviceError("no")
        return Reading(self.clock.now(), list(self.values))


class Bench:
    def __init__(self, cls, **every):
        self.clock, self.sink, self.count = SimulatedClock(PERIOD), ListSink(), 0
        self.knowledge = Knowledge("R2", self.clock, self.sink)
        self.knowledge.robot.drive = make_drive(
            "differential", track=0.33, max_wheel_speed=1.2, max_wheel_acceleration=1.5
        )
        self.sensors = {name: Scripted(name, self.clock) for name in every}
        watched = [Watched(self.sensors[name], Rate(n, PERIOD)) for name, n in every.items()]
        self.monitor = cls("monitor", watched, self.knowledge, self.sink)
        for signal in self.monitor.signals():
            self.knowledge.signals.declare(signal)
        self.knowledge.signals.freeze()

    def run(self, **values):
        for name, said in values.items():
            self.sensors[name].values = said
        self.monitor.run(self.clock.now(), self.count)
        self.clock.advance()
        self.count += 1
        return {
            name: self.knowledge.signals.read(name, self.clock.now()).tolist() for name in self.knowledge.signals.names
        }


def test_a_gyro_is_there_or_not():
    bench = Bench(OdometryMonitor, odometer=1)
    assert bench.run(odometer=[1.0, 2.0]) == {"wheel_travel": [1.0, 2.0]}
    bench = Bench(OdometryMonitor, odometer=1, gyro=1)
    assert bench.monitor.expects() == {"odometer": 2, "gyro": 1}
    assert bench.run(odometer=[1.0, 2.0], gyro=[0.3]) == {"wheel_travel": [1.0, 2.0], "gyro_rate": [0.3]}


def test_one_that_refuses_does_not_silence_the_other():
    bench = Bench(OdometryMonitor, odometer=1, gyro=1)
    assert bench.run(odometer=[1.0, 2.0])["wheel_travel"] == [1.0, 2.0]
    assert [e.sensor for e in bench.sink.events if isinstance(e, SensorFailed)] == ["gyro"]
    bench = Bench(FixMonitor, position=1, orientation=1)
    assert bench.run(orientation=[0.5])["compass"] == [0.5]


def test_fixes_are_slow_and_stay_valid_for_three_of_their_periods():
    bench = Bench(FixMonitor, position=10, orientation=10)
    assert bench.run(position=[1.0, 2.0, 0.1], orientation=[4.0]) == {
        "fix": [1.0, 2.0],
        "compass": [pytest.approx(4.0 - math.tau)],
    }
    assert bench.run(position=[7.0, 7.0, 7.0])["fix"] == [1.0, 2.0], "it is not read between"
    assert bench.monitor.max_age == pytest.approx(1.5)


@pytest.mark.parametrize(("cls", "sensors"), [(OdometryMonitor, {"odometer": 2}), (FixMonitor, {"position": 3})])
def test_infinity_is_no_place_and_no_way(cls, sensors):
    (name, size), extra = next(iter(sensors.items())), {"orientation": 1} if cls is FixMonitor else {}
    bench = Bench(cls, **{name: 1, **extra})
    found = bench.run(**{name: [math.inf] * size})
    assert all(math.isnan(v) for v in next(iter(found.values())))
