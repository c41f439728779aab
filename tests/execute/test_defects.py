"""Execute, when actions and devices do what they should not."""

import contextlib

import pytest

from rocs_bt.base.errors import DeviceError, InputError, PipelineError, WiringError
from rocs_bt.event import ListSink, TicketChanged
from rocs_bt.execute import RobotBody
from rocs_bt.interfaces.action import ActionFailed, AtomicAction, MacroAction, Progress, Reason
from rocs_bt.interfaces.pipeline import Priority, TicketState
from rocs_bt.knowledge import Knowledge

from ..gates import wide_gate

NORMAL, HIGH = Priority.NORMAL, Priority.HIGH
GO, REST = ("command", (1.0, 1.0)), ("neutral",)


def test_a_device_that_refuses_stops_the_wheels_and_fails_the_ticket(bench, do):
    ticket = bench.pipeline.submit(do("a", periods=9), NORMAL, "plan")
    bench.run()
    bench.wheels.broken = True
    assert bench.run() == [("act", "a"), REST]
    assert (ticket.state, ticket.failure.reason) == (TicketState.FAILED, Reason.REFUSED)
    assert "does not answer" in bench.of(TicketChanged)[-1].reason


@pytest.mark.parametrize("values", [[1.0], [1.0, 2.0, 3.0], [1.0, float("nan")], [float("inf"), 0.0]])
def test_what_is_no_command_never_reaches_the_device(bench, values):
    class Wild(AtomicAction):
        def act(self, body):
            body.motion.command(values)
            return Progress.RUNNING

    ticket = bench.pipeline.submit(Wild(), NORMAL, "plan")
    bench.run()
    assert bench.log == [REST]
    assert "wheels" in ticket.failure.evidence


def test_an_action_that_raises_stops_the_wheels_first_and_fails_its_ticket(bench):
    class Buggy(AtomicAction):
        def act(self, body):
            body.motion.command([1.0, 1.0])
            raise ZeroDivisionError("by nought")

    ticket = bench.pipeline.submit(Buggy(), NORMAL, "plan")
    with pytest.raises(ZeroDivisionError):
        bench.run()
    assert bench.log == [GO, REST]
    assert ticket.failure.evidence == "it raised ZeroDivisionError: by nought"
    assert bench.run() == []


def test_an_act_that_returns_nothing_is_told_so(bench):
    class Forgetful(AtomicAction):
        def act(self, body):
            pass

    bench.pipeline.submit(Forgetful(), NORMAL, "plan")
    with pytest.raises(PipelineError, match=r"Forgetful\.act must return a Progress or a Failure, it returned None"):
        bench.run()


@pytest.mark.parametrize("wrong", ["TurnLeft", None, 3])
def test_a_macro_that_yields_no_action_is_told_so(bench, chain, wrong):
    bench.pipeline.submit(chain("m", wrong), NORMAL, "plan")
    with pytest.raises(PipelineError, match="neither an AtomicAction nor a MacroAction"):
        bench.run()


def test_a_macro_that_yields_the_same_object_twice_is_told_so(bench, do, chain):
    same = do("a")
    bench.pipeline.submit(chain("m", same, same), NORMAL, "plan")
    with pytest.raises(PipelineError, match="same Do object twice"):
        bench.run(2)


def test_a_body_whose_wheels_are_no_actuator_is_refused(bench):
    with pytest.raises(WiringError, match=r"no actuator is named 'wheel'\. Did you mean 'wheels'"):
        RobotBody(
            knowledge=Knowledge("R1", bench.clock, ListSink()),
            locomotion=None,
            follower=None,
            clock=bench.clock,
            period=0.05,
            actuators={"wheels": wide_gate(bench.wheels, bench.clock)},
            motion="wheel",
            sink=bench.sink,
        )


def test_a_device_error_in_decompose_is_a_refusal_too(bench):
    class Asks(MacroAction):
        def decompose(self, body):
            raise DeviceError("no such register")
            yield

    ticket = bench.pipeline.submit(Asks(), NORMAL, "plan")
    bench.run()
    assert str(ticket.failure) == "REFUSED: no such register"


@pytest.mark.parametrize("where", ["act", "decompose", "call", "inner"])
def test_an_action_that_is_asked_for_the_impossible_fails_and_nothing_else_does(bench, do, chain, where):
    error = InputError("cruise must be positive.", "So must rate.")

    class Acts(AtomicAction):
        def act(self, body):
            body.motion.command([1.0, 1.0])
            raise error

    class Decomposes(MacroAction):
        def decompose(self, body):
            raise error
            yield

    class Calls(MacroAction):
        def decompose(self, body):
            raise error

    action = {"act": Acts, "decompose": Decomposes, "call": Calls, "inner": lambda: chain("m", Decomposes())}[where]()
    ticket = bench.pipeline.submit(action, NORMAL, "plan")
    after = bench.pipeline.submit(do("after"), NORMAL, "plan")
    log = bench.run(2)
    assert str(ticket.failure) == "CANNOT: cruise must be positive. So must rate."
    assert ticket.failure.reason is Reason.CANNOT
    assert after.state is TicketState.SUCCEEDED
    assert log[-2:] == [GO, REST]


@pytest.mark.parametrize("kind", [AtomicAction, MacroAction])
def test_a_macro_may_answer_what_its_action_cannot(bench, do, kind):
    class Cannot(kind):
        def act(self, body):
            raise InputError("no such path")

        def decompose(self, body):
            raise InputError("no such path")
            yield

    class Careful(MacroAction):
        def decompose(self, body):
            with contextlib.suppress(ActionFailed):
                yield Cannot()
            yield do("instead")

    ticket = bench.pipeline.submit(Careful(), NORMAL, "plan")
    bench.run(2)
    assert ("act", "instead") in bench.log
    assert ticket.state is TicketState.SUCCEEDED


def test_when_it_stops_one_that_raises_does_not_keep_the_others_from_stopping(bench, do, chain):
    action = do("a", periods=9)
    action.stop = lambda body: 1 / 0
    ticket = bench.pipeline.submit(chain("outer", chain("inner", action)), NORMAL, "plan")
    other = bench.pipeline.submit(do("b"), NORMAL, "plan")
    bench.run()
    bench.wheels.neutral = lambda: 1 / 0
    with pytest.raises(ZeroDivisionError):
        bench.execute.stop("operator")
    assert bench.log[-4:] == [("stop", "inner"), ("stop", "outer"), ("close", "inner"), ("close", "outer")]
    assert {ticket.state, other.state} == {TicketState.CANCELLED}
