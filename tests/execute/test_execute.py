"""Execute, one control period at a time."""

import contextlib
from copy import copy

from rocs_bt.event import ActuatorCommanded, AtomicStarted, ListSink
from rocs_bt.execute import Execute, RobotBody
from rocs_bt.interfaces.action import ActionFailed, AtomicAction, MacroAction, Progress, Reason
from rocs_bt.interfaces.pipeline import Priority, TicketState
from rocs_bt.knowledge import Knowledge

from ..gates import wide_gate

NORMAL, HIGH = Priority.NORMAL, Priority.HIGH
GO, REST = ("command", (1.0, 1.0)), ("neutral",)


def test_an_atomic_action_commands_once_a_period_and_then_the_wheels_rest_once(bench, do):
    ticket = bench.pipeline.submit(do("a", periods=2), NORMAL, "plan")
    assert bench.run() == [("act", "a"), GO]
    assert ticket.state is TicketState.RUNNING
    assert bench.run() == [("act", "a"), GO]
    assert ticket.state is TicketState.SUCCEEDED
    assert bench.run() == [REST]
    assert bench.run(5) == []


def test_the_record_shows_the_rest_as_zeros_and_the_route_of_every_command(bench, do):
    bench.pipeline.submit(do("a"), NORMAL, "plan")
    bench.run()
    bench.pipeline.submit(do("b"), HIGH, "rule")
    bench.run(3)
    seen = [(e.route, e.values) for e in bench.of(ActuatorCommanded)]
    assert seen == [("deliberative", [1.0, 1.0]), ("reactive", [1.0, 1.0]), ("idle", [0.0, 0.0])]
    assert [e.t for e in bench.of(ActuatorCommanded)] == [0.0, 0.05, 0.1]


def test_route_says_who_acts(bench, do):
    bench.run()
    assert bench.execute.route == "idle"
    bench.pipeline.submit(do("a", periods=3), NORMAL, "plan")
    bench.run()
    assert bench.execute.route == "deliberative"
    bench.pipeline.submit(do("b"), HIGH, "rule")
    bench.run()
    assert bench.execute.route == "reactive"
    bench.run()
    assert bench.execute.route == "idle"


def test_a_macro_is_decomposed_lazily_and_in_order(bench, do, chain):
    ticket = bench.pipeline.submit(chain("m", do("a"), do("b", periods=2), do("c")), NORMAL, "plan")
    assert bench.log == []
    assert bench.run() == [("yield", "m"), ("act", "a"), GO]
    assert bench.run() == [("yield", "m"), ("act", "b"), GO]
    assert bench.run() == [("act", "b"), GO]
    assert bench.run() == [("yield", "m"), ("act", "c"), GO]
    assert ticket.state is TicketState.RUNNING  # whether more comes is asked when the time has come
    assert bench.run() == [("close", "m"), REST]
    assert ticket.state is TicketState.SUCCEEDED


def test_each_atomic_action_is_announced_once(bench, do, chain):
    bench.pipeline.submit(chain("m", do("a", periods=3), do("b", periods=2)), NORMAL, "plan")
    bench.run(8)
    assert [(e.ticket, e.action, e.route) for e in bench.of(AtomicStarted)] == [(1, "Do", "deliberative")] * 2


def test_what_ends_without_a_command_makes_way_in_the_same_period(bench, do, chain):
    bench.pipeline.submit(chain("m", do("a", mute=True), do("b")), NORMAL, "plan")
    bench.pipeline.submit(do("c"), NORMAL, "plan")
    assert bench.run() == [("yield", "m"), ("act", "a"), ("yield", "m"), ("act", "b"), GO]
    assert bench.run() == [("close", "m"), ("act", "c"), GO]


def test_an_action_that_runs_without_a_command_leaves_the_wheels_at_rest(bench, do):
    bench.pipeline.submit(do("a"), NORMAL, "plan")
    bench.pipeline.submit(do("wait", periods=5, mute=True), NORMAL, "plan")
    bench.run()
    assert bench.run() == [("act", "wait"), REST]
    assert bench.run() == [("act", "wait")]


def test_a_macro_that_never_commands_is_a_runaway_and_others_go_on(bench, do, make_do, chain):
    endless = chain("m")
    endless.steps = (make_do(label="x", log=[], mute=True) for _ in range(10_000))
    ticket = bench.pipeline.submit(endless, NORMAL, "plan")
    after = bench.pipeline.submit(do("b"), NORMAL, "plan")
    bench.run()
    assert (ticket.state, ticket.failure.reason) == (TicketState.FAILED, Reason.RUNAWAY)
    assert after.state is TicketState.SUCCEEDED
    assert bench.log.count(("yield", "m")) == 16


def test_a_macro_of_endless_empty_macros_is_a_runaway(bench, make_chain, chain):
    endless = chain("m")
    endless.steps = (make_chain(label="empty", log=[]) for _ in range(10_000))
    ticket = bench.pipeline.submit(endless, NORMAL, "plan")
    bench.run()
    assert ticket.failure.reason is Reason.RUNAWAY


def test_a_macro_that_yields_itself_for_ever_is_a_runaway(bench):
    class Deep(MacroAction):
        def decompose(self, body):
            yield Deep()

    ticket = bench.pipeline.submit(Deep(), NORMAL, "plan")
    bench.run()
    assert ticket.failure.reason is Reason.RUNAWAY


def test_many_short_tickets_are_no_runaway(bench, do):
    tickets = [bench.pipeline.submit(do(str(i), mute=True), NORMAL, "plan") for i in range(40)]
    bench.run()
    assert {t.state for t in tickets} == {TicketState.SUCCEEDED}


def test_a_reflex_stops_what_runs_once_before_it_commands(bench, do, chain):
    inner = chain("inner", do("a", periods=9), do("never"))
    ticket = bench.pipeline.submit(chain("outer", inner), NORMAL, "plan")
    bench.run(2)
    bench.pipeline.submit(do("reflex"), HIGH, "rule")
    assert bench.run() == [
        ("stop", "a"),
        ("stop", "inner"),
        ("stop", "outer"),
        ("close", "inner"),
        ("close", "outer"),
        ("act", "reflex"),
        GO,
    ]
    assert (ticket.state, ticket.cancelled_by, ticket.preempted) == (TicketState.CANCELLED, "rule", True)


def test_what_never_began_is_not_stopped(bench, do):
    bench.pipeline.submit(do("a", periods=9), NORMAL, "plan")
    bench.pipeline.submit(do("reflex"), HIGH, "rule")
    assert bench.run(2) == [("act", "reflex"), GO, REST]


def test_a_cancelled_action_is_stopped_and_the_wheels_rest(bench, do):
    ticket = bench.pipeline.submit(do("a", periods=9), NORMAL, "plan")
    bench.run()
    bench.pipeline.cancel(ticket, "leaf")
    assert bench.run() == [("stop", "a"), REST]


def test_while_held_a_normal_action_waits_at_rest_and_then_goes_on(bench, do):
    ticket = bench.pipeline.submit(do("a", periods=3), NORMAL, "plan")
    bench.run()
    bench.pipeline.hold(True)
    assert bench.run(3) == [REST]
    bench.pipeline.hold(False)
    assert bench.run() == [("act", "a"), GO]
    assert ticket.state is TicketState.RUNNING


def test_a_held_macro_is_not_decomposed(bench, do, chain):
    bench.pipeline.hold(True)
    bench.pipeline.submit(chain("m", do("a")), NORMAL, "plan")
    assert bench.run(3) == []


def test_a_failure_reaches_the_macro_at_its_yield_and_can_be_answered(bench, do, broken):
    class TryAgain(MacroAction):
        def decompose(self, body):
            try:
                yield do("a", ends=broken)
            except ActionFailed as error:
                bench.log.append(("caught", str(error)))
            yield do("b")

    ticket = bench.pipeline.submit(TryAgain(), NORMAL, "plan")
    assert bench.run(2) == [("act", "a"), ("caught", "BLOCKED: a wall"), ("act", "b"), GO, REST]
    assert ticket.state is TicketState.SUCCEEDED


def test_a_failure_nobody_answers_fails_the_ticket_with_its_evidence(bench, do, chain, broken):
    ticket = bench.pipeline.submit(chain("outer", chain("inner", do("a", ends=broken), do("b"))), NORMAL, "plan")
    other = bench.pipeline.submit(do("c"), NORMAL, "plan")
    assert bench.run()[-2:] == [("act", "c"), GO]
    assert (ticket.state, ticket.failure) == (TicketState.FAILED, broken)
    assert ("act", "b") not in bench.log
    assert ("stop", "inner") not in bench.log
    assert other.state is TicketState.SUCCEEDED


def test_what_a_failing_action_commanded_does_not_stay(bench):
    class Rash(AtomicAction):
        def act(self, body):
            body.motion.command([1.0, 1.0])
            raise ActionFailed(Reason.BLOCKED, "after the fact")

    ticket = bench.pipeline.submit(Rash(), NORMAL, "plan")
    assert bench.run() == [GO, REST]
    assert str(ticket.failure) == "BLOCKED: after the fact"


def test_nor_when_a_macro_answers_and_then_waits(bench, do):
    class Rash(AtomicAction):
        def act(self, body):
            body.motion.command([1.0, 1.0])
            raise ActionFailed(Reason.BLOCKED)

    class Patient(MacroAction):
        def decompose(self, body):
            with contextlib.suppress(ActionFailed):
                yield Rash()
            yield do("wait", mute=True, periods=3)

    bench.pipeline.submit(Patient(), NORMAL, "plan")
    assert bench.run() == [GO, ("act", "wait"), REST]


def test_a_macro_may_be_a_fixed_sequence(bench, do, broken):
    class Pair(MacroAction):
        steps: tuple

        def decompose(self, body):
            return iter(self.steps)

    good = bench.pipeline.submit(Pair(steps=(do("a"), do("b"))), NORMAL, "plan")
    bad = bench.pipeline.submit(Pair(steps=(do("c", ends=broken), do("d"))), NORMAL, "plan")
    bench.run(5)
    assert [e[1] for e in bench.log if e[0] == "act"] == ["a", "b", "c"]
    assert (good.state, bad.state) == (TicketState.SUCCEEDED, TicketState.FAILED)


def test_stop_rests_the_wheels_and_cancels_everything(bench, do):
    tickets = [bench.pipeline.submit(do(label, periods=9), NORMAL, "plan") for label in "ab"]
    bench.run()
    bench.execute.stop("operator")
    assert bench.log[-2:] == [REST, ("stop", "a")]
    assert {(t.state, t.cancelled_by) for t in tickets} == {(TicketState.CANCELLED, "operator")}
    assert bench.run(3) == []


def test_stop_in_mid_act_drops_what_the_action_commands_after_it(bench):
    class Late(AtomicAction):
        def act(self, body):
            bench.execute.stop("heartbeat")  # as from another thread
            body.motion.command([1.0, 1.0])
            return Progress.RUNNING

        def stop(self, body):
            bench.log.append(("stop", "late"))

    bench.pipeline.submit(Late(), NORMAL, "plan")
    assert bench.run() == [REST, ("stop", "late")]
    assert bench.run() == []


def test_an_action_cancelled_in_its_last_act_is_stopped_and_does_not_succeed(bench):
    class Last(AtomicAction):
        def act(self, body):
            bench.pipeline.submit(reflex, HIGH, "rule")  # as from another thread
            body.motion.command([1.0, 1.0])
            return Progress.SUCCEEDED

        def stop(self, body):
            bench.log.append(("stop", "last"))

    class Reflex(AtomicAction):
        def act(self, body):
            body.motion.command([-1.0, -1.0])
            return Progress.SUCCEEDED

    reflex = Reflex()
    ticket = bench.pipeline.submit(Last(), NORMAL, "plan")
    assert bench.run() == [GO]
    assert ticket.state is TicketState.CANCELLED
    assert bench.run() == [("stop", "last"), ("command", (-1.0, -1.0))]


def test_an_actuator_that_only_one_action_uses_rests_while_another_is_commanded(bench, do):
    lamp = copy(bench.wheels)
    lamp.name, lamp.log = "lamp", []
    body = RobotBody(
        knowledge=Knowledge("R1", bench.clock, ListSink()),
        locomotion=None,
        follower=None,
        clock=bench.clock,
        period=0.05,
        actuators={"wheels": wide_gate(bench.wheels, bench.clock), "lamp": wide_gate(lamp, bench.clock)},
        motion="wheels",
        sink=bench.sink,
    )

    class Shine(AtomicAction):
        def act(self, body):
            body.actuators["lamp"].command([1.0, 0.0])
            return Progress.SUCCEEDED

    bench.execute = Execute(bench.pipeline, body)
    bench.pipeline.submit(Shine(), NORMAL, "plan")
    bench.pipeline.submit(do("drive", periods=3), NORMAL, "plan")
    bench.run(3)
    assert lamp.log == [("command", (1.0, 0.0)), REST]
