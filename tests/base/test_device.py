"""The actuator's watchdog: a dead mind cannot drive."""

import threading

import pytest

from rocs_bt.clock import SimulatedClock
from rocs_bt.device import Actuator, Watchdog
from rocs_bt.errors import DeviceError


class Wheels(Actuator):
    def __init__(self):
        super().__init__("wheels", 2)
        self.value = [0.0, 0.0]

    def command(self, values):
        self.value = list(values)

    def neutral(self):
        self.value = [0.0, 0.0]


@pytest.fixture
def clock():
    return SimulatedClock(0.005)


def test_a_command_holds_for_its_age_and_not_longer(clock):
    wheels, expired = Wheels(), []
    dog = Watchdog(wheels, clock, 0.2, expired.append)
    clock.advance(7)
    dog.command([1.0, 1.0])
    for _ in range(40):
        clock.advance()
        assert dog.check() is False
        assert wheels.value == [1.0, 1.0]
    clock.advance()
    assert dog.check() is True
    assert wheels.value == [0.0, 0.0]
    assert expired == [clock.now()]
    assert dog.check() is False, "it goes to neutral once"


def test_each_command_starts_the_age_anew(clock):
    wheels = Wheels()
    dog = Watchdog(wheels, clock, 0.2)
    for _ in range(10):
        dog.command([1.0, 1.0])
        clock.advance(30)
        assert dog.check() is False


def test_after_it_was_shut_nobody_drives(clock):
    wheels = Wheels()
    dog = Watchdog(wheels, clock, 0.2)
    dog.command([1.0, 1.0])
    dog.shut()
    assert wheels.value == [0.0, 0.0]
    with pytest.raises(DeviceError, match="'wheels' was shut"):
        dog.command([1.0, 1.0])


def test_neutral_does_not_wait_for_a_command_that_hangs(clock):
    release, entered = threading.Event(), threading.Event()

    class Hanging(Wheels):
        def command(self, values):
            super().command(values)
            entered.set()
            release.wait(10.0)

    wheels = Hanging()
    dog = Watchdog(wheels, clock, 0.2)
    thread = threading.Thread(target=dog.command, args=([1.0, 1.0],))
    thread.start()
    assert entered.wait(5.0)
    dog.shut()
    assert wheels.value == [0.0, 0.0]
    release.set()
    thread.join()
