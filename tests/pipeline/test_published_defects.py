"""What the published C++ code does wrong with its Pipeline, and this one does not.

Its `push` never updates the priority on top, so the queue is a mailbox of one slot in which the last writer wins; its
`next` is the only way out, and nothing tells what became of an action.
"""

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.event import ListSink, TicketChanged
from rocs_bt.execute import Execute, RobotBody
from rocs_bt.interfaces.action import AtomicAction, MacroAction, Progress
from rocs_bt.interfaces.device import Actuator
from rocs_bt.interfaces.pipeline import Pipeline, Priority, TicketState
from rocs_bt.knowledge import Knowledge

from ..gates import wide_gate

NORMAL, HIGH = Priority.NORMAL, Priority.HIGH


class Wheels(Actuator):
    def __init__(self):
        super().__init__("wheels", 1)
        self.commands = []

    def command(self, values):
        self.commands.append(values[0])

    def neutral(self):
        self.commands.append(0.0)


class Locomotion(AtomicAction):
    """Commands its speed for some periods."""

    speed: float
    periods: int = 1

    def act(self, body):
        self.periods -= 1
        body.motion.command([self.speed])
        return Progress.RUNNING if self.periods > 0 else Progress.SUCCEEDED


class Three(MacroAction):
    def decompose(self, body):
        yield Locomotion(speed=1.0)
        yield Locomotion(speed=2.0)
        yield Locomotion(speed=3.0)


class Robot:
    def __init__(self):
        self.clock, self.sink, self.wheels = SimulatedClock(0.05), ListSink(), Wheels()
        self.pipeline = Pipeline(self.clock, self.sink)
        body = RobotBody(
            knowledge=Knowledge("R1", self.clock, ListSink()),
            locomotion=None,
            follower=None,
            clock=self.clock,
            period=0.05,
            actuators={"wheels": wide_gate(self.wheels, self.clock)},
            motion="wheels",
            sink=self.sink,
        )
        self.execute = Execute(self.pipeline, body)

    def run(self, periods):
        for _ in range(periods):
            self.execute.run(self.clock.now())
            self.clock.advance()
        return self.wheels.commands

    def told(self):
        return [e for e in self.sink.events if isinstance(e, TicketChanged)]


@pytest.fixture
def robot():
    return Robot()


def test_a_reflex_is_not_lost_to_a_plan_that_pushes_after_it(robot):
    """There: push 60, push 1 leaves the plan's action only."""
    robot.pipeline.submit(Locomotion(speed=-60.0), HIGH, "rule")
    robot.pipeline.submit(Locomotion(speed=1.0), NORMAL, "plan")
    assert robot.run(3) == [-60.0, 1.0, 0.0]


def test_a_reflex_replaces_a_plan_that_pushed_before_it(robot):
    robot.pipeline.submit(Locomotion(speed=1.0), NORMAL, "plan")
    robot.pipeline.submit(Locomotion(speed=-60.0), HIGH, "rule")
    assert robot.run(3) == [-60.0, 0.0]


def test_three_pushed_actions_all_run_in_order(robot):
    """There: push 1, 1, 1 leaves only the third."""
    for speed in (1.0, 2.0, 3.0):
        robot.pipeline.submit(Locomotion(speed=speed), NORMAL, "plan")
    assert robot.run(4) == [1.0, 2.0, 3.0, 0.0]


def test_a_macro_of_three_runs_in_order_in_three_periods(robot):
    """There: each child goes through the queue again, at 6 commands a second, on old data."""
    robot.pipeline.submit(Three(), NORMAL, "plan")
    assert robot.run(4) == [1.0, 2.0, 3.0, 0.0]


def test_nothing_is_dropped_without_a_word(robot):
    """There: a push of a lower value is dropped silently."""
    for _ in range(3):
        robot.pipeline.submit(Locomotion(speed=1.0), NORMAL, "plan")
    robot.pipeline.submit(Locomotion(speed=-60.0), HIGH, "rule")
    robot.run(3)
    ends = [(e.ticket, e.state, e.by) for e in robot.told() if TicketState(e.state).done]
    assert ends == [
        (1, "CANCELLED", "rule"),
        (2, "CANCELLED", "rule"),
        (3, "CANCELLED", "rule"),
        (4, "SUCCEEDED", "rule"),
    ]


def test_a_running_action_is_pre_empted(robot):
    """There: act() runs to its end on the Execute thread."""
    robot.pipeline.submit(Locomotion(speed=1.0, periods=100), NORMAL, "plan")
    robot.run(2)
    robot.pipeline.submit(Locomotion(speed=-60.0), HIGH, "rule")
    assert robot.run(1) == [1.0, 1.0, -60.0]


@pytest.mark.parametrize("moment", range(6))
def test_a_reflex_is_not_lost_whenever_it_comes_while_a_macro_runs(robot, moment):
    """There: one push in six is lost when an action that takes 20 ms pushes its child afterwards."""
    robot.pipeline.submit(Three(), NORMAL, "plan")
    robot.run(moment)
    ticket = robot.pipeline.submit(Locomotion(speed=-60.0), HIGH, "rule")
    robot.run(1)
    assert ticket.state is TicketState.SUCCEEDED
    assert robot.wheels.commands[-1] == -60.0


def test_a_reflex_submitted_in_the_midst_of_an_act_is_next(robot):
    tickets = []

    class Slow(AtomicAction):
        def act(self, body):
            tickets.append(robot.pipeline.submit(Locomotion(speed=-60.0), HIGH, "rule"))
            body.motion.command([1.0])
            return Progress.RUNNING

    robot.pipeline.submit(Slow(), NORMAL, "plan")
    assert robot.run(2) == [1.0, -60.0]
    assert tickets[0].state is TicketState.SUCCEEDED


def test_when_a_reflex_is_over_the_wheels_do_not_keep_its_speed(robot):
    """There: the wheels keep the reflex's speed until the planner's chain comes through."""
    robot.pipeline.submit(Locomotion(speed=-60.0), HIGH, "rule")
    assert robot.run(2) == [-60.0, 0.0]


def test_what_became_of_an_action_is_told(robot):
    ticket = robot.pipeline.submit(Locomotion(speed=1.0), NORMAL, "plan")
    states = [ticket.state]
    robot.run(1)
    states += [TicketState(e.state) for e in robot.told()]
    assert states == [TicketState.QUEUED, TicketState.QUEUED, TicketState.RUNNING, TicketState.SUCCEEDED]
