"""The hold of a safety gate, and the emergency stop: neutral until it is released and somebody says go."""

from __future__ import annotations

import threading

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import ActuatorError, DeviceError
from rocs_bt.devices.emergency_stop import EmergencyStop
from rocs_bt.devices.host import Host
from rocs_bt.event import ListSink, MotionHeld, MotionReleased
from rocs_bt.interfaces.actuator_limits import ActuatorLimits
from rocs_bt.interfaces.device import Actuator
from rocs_bt.interfaces.safety_gate import SafetyGate


class Wheels(Actuator):
    """Keeps every command; the first may wait for an event."""

    def __init__(self):
        super().__init__("wheels", 2)
        self.log, self.entered, self.leave = [], threading.Event(), threading.Event()
        self.leave.set()

    def command(self, values):
        self.entered.set()
        assert self.leave.wait(60.0)
        self.log.append(list(values))

    def neutral(self):
        self.log.append("neutral")


@pytest.fixture
def sink():
    return ListSink()


@pytest.fixture
def gate(sink):
    wheels, limits = Wheels(), ActuatorLimits((-1.2,), (1.2,), together=True)
    gate = SafetyGate(wheels, SimulatedClock(0.05), limits, period=0.05, max_age=0.2, sink=sink, agent="R2")
    gate.log, gate.wheels = wheels.log, wheels
    return gate


@pytest.fixture
def stop(gate):
    stop = EmergencyStop()
    stop.attach([gate])
    return stop


def test_a_gate_that_is_held_answers_each_command_by_neutral(gate, sink):
    assert gate.give([0.5, 0.5]) == [0.5, 0.5]
    gate.hold("the button")
    assert gate.held == "the button"
    assert not gate.active
    assert gate.give([0.7, 0.7]) == gate.give([9.0, 9.0]) == [0.0, 0.0]
    assert gate.log == [[0.5, 0.5], "neutral", "neutral", "neutral"]
    gate.hold("the button")
    gate.release("R. Daneel")
    gate.release()
    assert gate.give([0.7, 0.7]) == [0.7, 0.7]
    assert gate.active
    assert sink.events == [  # neither limits nor repetitions are reported
        MotionHeld(t=0.0, agent="R2", actuator="wheels", reason="the button"),
        MotionReleased(t=0.0, agent="R2", actuator="wheels", by="R. Daneel"),
    ]


def test_a_command_in_execution_ends_in_neutral(gate):
    gate.wheels.leave.clear()
    command = threading.Thread(target=gate.give, args=([0.5, 0.5],))
    command.start()
    assert gate.wheels.entered.wait(60.0)
    gate.hold("the button")
    gate.wheels.leave.set()
    command.join()
    assert gate.log[-2:] == [[0.5, 0.5], "neutral"]


def test_after_a_stop_it_needs_a_release_and_then_a_go(gate, stop):
    assert stop.go("nobody needs it")
    stop.stop("the button")
    assert (stop.reason, gate.held) == ("emergency stop: the button",) * 2
    assert not stop.go("too early")
    stop.release()
    assert stop.reason == gate.held == "emergency stop released, waiting for go"
    assert gate.give([0.5, 0.5]) == [0.0, 0.0]
    assert stop.go("the terminal")
    assert stop.reason == gate.held == ""
    assert gate.give([0.5, 0.5]) == [0.5, 0.5]
    stop.release()
    assert stop.reason == ""


def test_each_source_must_release_it(gate, stop):
    stop.stop("the button", "button")
    stop.stop("a bumper", "bumper")
    stop.stop("a bumper", "bumper")
    assert gate.held == "emergency stop: the button, a bumper"
    stop.release("button")
    assert gate.held == "emergency stop: a bumper"
    assert not stop.go()
    stop.release("bumper")
    stop.stop("the button", "button")  # again, before somebody said go
    assert not stop.go()
    stop.release("button")
    assert stop.go()


def test_with_confirm_it_waits_from_the_beginning_and_only_while_ready(gate):
    stop = EmergencyStop(confirm=True)
    assert stop.reason == "waiting for go"
    stop.ready = False
    assert not stop.go()
    stop.ready = True
    assert stop.go()
    assert stop.reason == ""


@pytest.mark.parametrize("error", [OSError("no network"), KeyboardInterrupt()], ids=["driver", "signal"])
def test_a_gate_that_raises_does_not_keep_the_others_from_the_hold(gate, error):
    def fail():
        assert gate.held  # marked before the first neutral
        raise error

    broken = Wheels()
    broken.neutral = fail
    limits = ActuatorLimits((-1.2,), (1.2,), together=True)
    gates = [
        SafetyGate(broken, SimulatedClock(0.05), limits, period=0.05, max_age=0.2),
        gate,
    ]
    stop = EmergencyStop()
    stop.attach(gates)
    gate.give([0.5, 0.5])
    with pytest.raises((ActuatorError, KeyboardInterrupt)):
        stop.stop("the button")
    assert [each.held for each in gates] == ["emergency stop: the button"] * 2
    assert gate.log == [[0.5, 0.5], "neutral"]


def test_a_stop_before_the_gates_are_known_holds_them(gate, sink):
    stop = EmergencyStop()
    stop.stop("the button")
    stop.attach([gate])
    assert gate.held == "emergency stop: the button"


def test_drivers_reach_it_through_their_host(gate, stop):
    host = Host(SimulatedClock(0.05), stop)
    host.emergency_stop("the button", "panel")
    assert gate.held
    host.emergency_released("panel")
    assert host.go("/go")
    assert not gate.held
    with pytest.raises(DeviceError, match="isolated actuator cannot stop the robot"):
        Host(SimulatedClock(0.05)).emergency_stop("the button")
