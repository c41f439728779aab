"""The clock of a robot in a simulator: it follows /clock at any rate, and stands still with it."""

import math
import threading
import time

import pytest

from rocs_bt.base.errors import DeviceError
from rocs_bt.ros2.messages import fields as messages
from rocs_bt.ros2.messages.type_store import TypeStore
from rocs_bt.ros2.network import sim_clock
from rocs_bt.ros2.network.sim_clock import SimTimeClock
from rocs_bt.ros2.network.transport import Sample

TYPES = TypeStore()


class Simulator:
    """Transport with a simulator that publishes its time each 10 ms; and the wall clock, which a test moves."""

    types = TYPES

    def __init__(self, monkeypatch, rate):
        self.rate, self.wall, self.simulated, self.messages = rate, 100.0, 40.0, []
        monkeypatch.setattr(sim_clock.time, "monotonic", lambda: self.wall)

    def reader(self, topic, type, qos):
        assert (topic, type, qos.reliability) == ("/clock", "rosgraph_msgs/msg/Clock", "best_effort")
        return self

    def take_all(self):
        taken, self.messages = self.messages[-10:], []
        return taken

    def publish(self, t):
        data = TYPES.serialize(TYPES.make("rosgraph_msgs/msg/Clock", **messages.clock(t)))
        self.messages.append(Sample(data, 0.0))

    def run(self, seconds, each=lambda: None):
        """Let wall time pass, with a call each millisecond."""
        for _ in range(round(seconds * 1000)):
            self.wall += 0.001
            before, self.simulated = self.simulated, self.simulated + 0.001 * self.rate
            if int(before / 0.01) != int(self.simulated / 0.01):
                self.publish(self.simulated)
            each()


@pytest.fixture(params=[0.2, 1.0, 3.0], ids=lambda rate: f"rate {rate}")
def simulator(request, monkeypatch):
    return Simulator(monkeypatch, request.param)


@pytest.fixture
def clock(simulator):
    clock = SimTimeClock(simulator)
    assert math.isnan(clock.ros_time())
    simulator.run(3.0, clock.ros_time)
    clock.start()
    return clock


def test_it_is_within_a_message_of_the_simulator_and_never_goes_back(simulator, clock):
    began, errors, times = simulator.simulated, [], []

    def look():
        times.append(clock.now())
        errors.append(abs(times[-1] - (simulator.simulated - began)))

    simulator.run(2.0, look)
    assert max(errors) < 0.011 + 0.002 * simulator.rate  # a message, and a look
    assert times == sorted(times)
    assert len(set(times)) > 0.5 * len(times)  # between messages, too
    assert clock.at(simulator.simulated) == pytest.approx(simulator.simulated - began, abs=0.011)
    assert clock.wall_time(1.0) == pytest.approx(1.0 / simulator.rate, rel=0.1)


def test_it_stands_still_when_the_simulator_pauses(simulator, clock):
    simulator.run(1.0, clock.now)
    stopped = simulator.simulated
    for _ in range(1200):
        simulator.wall += 0.001
        clock.now()
    still = clock.ros_time()
    assert still == pytest.approx(stopped, abs=0.02)
    simulator.wall += 0.3
    assert clock.ros_time() == still
    assert clock.stopped_for == pytest.approx(1.5, abs=0.1)
    simulator.run(1.0, clock.now)
    assert clock.stopped_for < 0.1
    assert clock.ros_time() == pytest.approx(simulator.simulated, abs=0.015)
    assert clock.wall_time(1.0) == pytest.approx(1.0 / simulator.rate, rel=0.1)  # the pause does not count


def test_a_simulator_that_restarts_is_a_fault(simulator, clock):
    simulator.run(0.1, clock.now)
    clock.check()
    before = clock.now()
    for t in (0.01, 0.02):  # the first one is reported
        simulator.publish(t)
        simulator.wall += 0.01
        assert clock.now() >= before
    with pytest.raises(DeviceError, match=r"/clock jumped back from .* to 0\.010 s: the simulator was restarted"):
        clock.check()


def test_without_a_simulator_the_wait_ends_with_what_to_do(monkeypatch):
    simulator = Simulator(monkeypatch, 1.0)

    def sleep(seconds):
        simulator.wall += seconds

    monkeypatch.setattr(sim_clock.time, "sleep", sleep)
    clock = SimTimeClock(simulator)
    with pytest.raises(DeviceError, match=r"no message on /clock within 5 s\. Start the simulator"):
        clock.wait_for_message(5.0)
    clock.wait_for_message(5.0, lambda: "SIGINT ended the run")


class Live:
    """Transport with a simulator on the real wall clock."""

    types = TYPES

    def __init__(self, rate):
        self.rate, self.began = rate, time.monotonic()

    def reader(self, topic, type, qos):
        return self

    def take_all(self):
        now = math.floor((time.monotonic() - self.began) * self.rate / 0.01) * 0.01
        return [Sample(TYPES.serialize(TYPES.make("rosgraph_msgs/msg/Clock", **messages.clock(now))), 0.0)]


@pytest.mark.parametrize("rate", [0.5, 4.0])
def test_a_wait_takes_simulated_time(rate):
    clock = SimTimeClock(Live(rate))
    clock.wait_for_message(1.0)
    time.sleep(0.02)
    clock.start()
    began = time.monotonic()
    assert clock.wait_until(0.4, threading.Event())
    assert clock.now() >= 0.4
    took = time.monotonic() - began
    assert took > 0.2 / rate
    assert took < 0.4 or rate < 1.0  # less than on wall time


def test_a_wait_ends_by_its_event_and_by_its_patience_while_the_clock_stands_still():
    clock, stop = SimTimeClock(Live(0.0)), threading.Event()
    clock.wait_for_message(1.0)
    clock.start()
    assert clock.wait_until(1.0, stop, patience=0.05)
    threading.Timer(0.05, stop.set).start()
    assert not clock.wait_until(1.0, stop)
