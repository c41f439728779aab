"""The Pipeline by itself: order, pre-emption, hold, ends, and threads."""

import threading

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import PipelineError
from rocs_bt.event import ListSink, TicketChanged
from rocs_bt.interfaces.action import AtomicAction, Failure, Progress, Reason
from rocs_bt.interfaces.pipeline import Pipeline, Priority, TicketState

NORMAL, HIGH = Priority.NORMAL, Priority.HIGH


class Nod(AtomicAction):
    angle: float = 0.3

    def act(self, body):
        return Progress.SUCCEEDED


@pytest.fixture
def sink():
    return ListSink()


@pytest.fixture
def pipeline(sink):
    return Pipeline(SimulatedClock(0.05), sink, "R1")


def test_normal_is_first_in_first_out(pipeline):
    tickets = [pipeline.submit(Nod(), NORMAL, "leaf") for _ in range(3)]
    for ticket in tickets:
        assert pipeline.top() is ticket
        pipeline.start(ticket)
        pipeline.succeed(ticket)
    assert pipeline.top() is None


def test_a_high_submission_cancels_all_normal_ones_and_is_next(pipeline):
    running, waiting = (pipeline.submit(Nod(), NORMAL, "leaf") for _ in range(2))
    pipeline.start(running)
    reflex = pipeline.submit(Nod(), HIGH, "rules/Flinch")
    assert pipeline.queued() == (reflex,)
    for ticket in (running, waiting):
        assert (ticket.state, ticket.cancelled_by, ticket.preempted) == (TicketState.CANCELLED, "rules/Flinch", True)


def test_a_high_submission_leaves_high_ones_alone(pipeline):
    first, second = (pipeline.submit(Nod(), HIGH, "rule") for _ in range(2))
    assert pipeline.queued() == (first, second)


def test_the_plan_is_blocked_while_one_of_its_actions_waits_for_a_reflex(pipeline):
    first = pipeline.submit(Nod(), NORMAL, "leaf")
    assert not pipeline.blocked
    pipeline.hold(True)
    pipeline.submit(Nod(), HIGH, "rules/Halt")
    assert pipeline.blocked  # what was cut off waits
    pipeline.submit(Nod(), HIGH, "rules/Halt")
    assert pipeline.blocked
    pipeline.cancel(first, "leaf")
    assert not pipeline.blocked  # its leaf was halted
    second = pipeline.submit(Nod(), NORMAL, "leaf")
    assert pipeline.blocked
    pipeline.cancel(second, "leaf")
    assert not pipeline.blocked
    pipeline.submit(Nod(), NORMAL, "leaf")
    pipeline.hold(False)
    assert not pipeline.blocked


def test_normal_ones_wait_behind_high_ones_and_while_held(pipeline):
    reflex = pipeline.submit(Nod(), HIGH, "rule")
    pipeline.hold(True)
    normal = pipeline.submit(Nod(), NORMAL, "leaf")
    assert pipeline.top() is reflex
    pipeline.start(reflex)
    pipeline.succeed(reflex)
    assert pipeline.top() is None
    pipeline.hold(False)
    assert pipeline.top() is normal


def test_a_cancelled_ticket_is_neither_started_nor_ended_again(pipeline):
    ticket = pipeline.submit(Nod(), NORMAL, "leaf")
    assert pipeline.cancel(ticket, "leaf")
    assert not pipeline.cancel(ticket, "leaf")
    assert not pipeline.start(ticket)
    assert not pipeline.succeed(ticket)
    assert not pipeline.fail(ticket, Failure(Reason.OTHER))
    assert (ticket.state, ticket.failure, ticket.preempted) == (TicketState.CANCELLED, None, False)


def test_the_same_object_is_not_queued_twice_but_may_come_again_later(pipeline):
    action = Nod()
    ticket = pipeline.submit(action, NORMAL, "leaf")
    with pytest.raises(PipelineError, match="Nod was submitted by 'leaf' while the same object is queued"):
        pipeline.submit(action, HIGH, "leaf")
    pipeline.cancel(ticket, "leaf")
    assert pipeline.submit(action, NORMAL, "leaf").number == 2


def test_a_refused_submission_cancels_nothing(pipeline):
    action = Nod()
    pipeline.submit(action, HIGH, "rule")
    normal = pipeline.submit(Nod(), NORMAL, "leaf")
    with pytest.raises(PipelineError):
        pipeline.submit(action, HIGH, "rule")
    assert normal.state is TicketState.QUEUED


def test_every_change_is_an_event_with_who_and_why(pipeline, sink):
    ticket = pipeline.submit(Nod(angle=0.5), NORMAL, "leaf")
    pipeline.start(ticket)
    pipeline.fail(ticket, Failure(Reason.BLOCKED, "a wall"))
    seen = [(e.state, e.by, e.reason) for e in sink.events if isinstance(e, TicketChanged)]
    assert seen == [("QUEUED", "leaf", ""), ("RUNNING", "leaf", ""), ("FAILED", "leaf", "BLOCKED: a wall")]
    assert {(e.agent, e.ticket, e.action, e.parameters["angle"]) for e in sink.events} == {("R1", 1, "Nod", 0.5)}


def test_clear_cancels_everything(pipeline):
    tickets = [pipeline.submit(Nod(), p, "x") for p in (HIGH, NORMAL, HIGH, NORMAL)]
    pipeline.clear("operator")
    assert pipeline.queued() == ()
    assert {t.cancelled_by for t in tickets} == {"operator", "x"}


@pytest.mark.parametrize("call", ["submit high", "cancel", "wake", "clear"])
def test_what_concerns_execute_wakes_it(pipeline, call):
    ticket = pipeline.submit(Nod(), NORMAL, "leaf")
    assert not pipeline.wait(0.0)
    {
        "submit high": lambda: pipeline.submit(Nod(), HIGH, "rule"),
        "cancel": lambda: pipeline.cancel(ticket, "leaf"),
        "wake": pipeline.wake,
        "clear": lambda: pipeline.clear("operator"),
    }[call]()
    assert pipeline.wait(0.0)
    assert not pipeline.wait(0.0)


@settings(deadline=None)
@given(st.lists(st.sampled_from(["normal", "high", "cancel", "start", "succeed", "fail"]), max_size=40))
def test_laws(operations):
    """Against the obvious model: two lists."""
    pipeline = Pipeline(SimulatedClock(0.05), ListSink())
    high, normal, tickets = [], [], []
    for operation in operations:
        head = (high or normal or [None])[0]
        if operation == "high":
            high.append(pipeline.submit(Nod(), HIGH, "rule"))
            normal.clear()
            tickets.append(high[-1])
        elif operation == "normal":
            normal.append(pipeline.submit(Nod(), NORMAL, "leaf"))
            tickets.append(normal[-1])
        elif head is not None and operation == "start":
            assert pipeline.start(head)
        elif head is not None:
            if operation == "cancel":
                assert pipeline.cancel(head, "x")
            elif operation == "succeed":
                assert pipeline.succeed(head)
            else:
                assert pipeline.fail(head, Failure(Reason.OTHER))
            (high or normal).pop(0)
        assert pipeline.queued() == (*high, *normal)
        assert pipeline.top() is (high or normal or [None])[0]
    assert [t.number for t in tickets] == list(range(1, len(tickets) + 1))
    assert all(t.state.done == (t not in pipeline.queued()) for t in tickets)


def test_under_threads_nothing_is_lost_and_each_ticket_ends_once():
    sink = ListSink()
    pipeline = Pipeline(SimulatedClock(0.05), sink)
    submitted, done = [], threading.Event()

    def submit(priority):
        for _ in range(200):
            submitted.append(pipeline.submit(Nod(), priority, priority.name))

    def serve():
        while not (done.is_set() and pipeline.top() is None):
            ticket = pipeline.top()
            if ticket is not None and pipeline.start(ticket):
                pipeline.succeed(ticket)

    server = threading.Thread(target=serve)
    clients = [threading.Thread(target=submit, args=(p,)) for p in (NORMAL, HIGH, NORMAL)]
    for thread in (server, *clients):
        thread.start()
    for thread in clients:
        thread.join()
    done.set()
    server.join()
    assert len(submitted) == 600
    assert len({t.number for t in submitted}) == 600
    assert {t.state for t in submitted if t.priority is HIGH} == {TicketState.SUCCEEDED}
    ends = [e.ticket for e in sink.events if TicketState(e.state).done]
    assert sorted(ends) == list(range(1, 601))
