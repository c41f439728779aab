"""A bench for Execute alone: one wheel actuator that writes down what happens to it, and actions that do as told."""

import math

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import DeviceError
from rocs_bt.event import ListSink
from rocs_bt.execute import Execute, RobotBody
from rocs_bt.interfaces.action import AtomicAction, Failure, MacroAction, Progress, Reason
from rocs_bt.interfaces.device import Actuator
from rocs_bt.interfaces.pipeline import Pipeline
from rocs_bt.knowledge import Knowledge

from ..gates import wide_gate

PERIOD = 0.05


class Wheels(Actuator):
    def __init__(self, log):
        super().__init__("wheels", 2)
        self.log = log
        self.moving = False
        self.broken = False

    def command(self, values):
        if self.broken:
            raise DeviceError("the motor driver does not answer")
        self.log.append(("command", tuple(values)))
        self.moving = any(values)

    def neutral(self):
        self.log.append(("neutral",))
        self.moving = False


class Bench:
    def __init__(self):
        self.log = []
        self.clock = SimulatedClock(PERIOD)
        self.sink = ListSink()
        self.wheels = Wheels(self.log)
        self.pipeline = Pipeline(self.clock, self.sink, "R1")
        self.body = RobotBody(
            knowledge=Knowledge("R1", self.clock, ListSink()),
            locomotion=None,
            follower=None,
            clock=self.clock,
            period=PERIOD,
            actuators={"wheels": wide_gate(self.wheels, self.clock)},
            motion="wheels",
            sink=self.sink,
        )
        self.execute = Execute(self.pipeline, self.body)

    def run(self, periods=1):
        """Let control periods pass; what happened in them."""
        before = len(self.log)
        for _ in range(periods):
            self.execute.run(self.clock.now())
            self.clock.advance()
        return self.log[before:]

    def of(self, kind):
        return [e for e in self.sink.events if isinstance(e, kind)]


class Do(AtomicAction):
    """Acts `periods` times, commanding each time unless it is mute, and then ends as `ends` says."""

    label: str
    log: list
    periods: float = 1
    mute: bool = False
    ends: Failure | None = None
    done = 0

    def act(self, body):
        self.done += 1
        self.log.append(("act", self.label))
        last = self.done >= self.periods
        if last and self.ends is not None:
            return self.ends
        if not self.mute:
            body.motion.command([1.0, 1.0])
        return Progress.SUCCEEDED if last else Progress.RUNNING

    def stop(self, body):
        self.log.append(("stop", self.label))


class Chain(MacroAction):
    """Yields the actions of `steps`; each may be an action or a function that makes one."""

    label: str
    log: list
    steps: list = ()

    def decompose(self, body):
        try:
            for step in self.steps:
                self.log.append(("yield", self.label))
                yield step
        finally:
            self.log.append(("close", self.label))

    def stop(self, body):
        self.log.append(("stop", self.label))


@pytest.fixture
def bench():
    return Bench()


@pytest.fixture(scope="session")
def make_bench():
    return Bench


@pytest.fixture
def do(bench):
    return lambda label, **more: Do(label=label, log=bench.log, **more)


@pytest.fixture
def chain(bench):
    return lambda label, *steps: Chain(label=label, log=bench.log, steps=list(steps))


@pytest.fixture
def broken():
    return Failure(Reason.BLOCKED, "a wall")


@pytest.fixture
def forever():
    return math.inf


@pytest.fixture(scope="session")
def make_do():
    return Do


@pytest.fixture(scope="session")
def make_chain():
    return Chain
