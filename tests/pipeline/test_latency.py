"""A planner's latency: what it decides takes effect later, submission and cancellation alike; a reflex never waits."""

import math

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.event import ListSink
from rocs_bt.interfaces.action import AtomicAction, Progress, Reason
from rocs_bt.interfaces.pipeline import Pipeline, Priority, TicketState

NORMAL, HIGH = Priority.NORMAL, Priority.HIGH
PERIOD = 0.05


class Nod(AtomicAction):
    angle: float = 0.3

    def act(self, body):
        return Progress.SUCCEEDED


def make(latency):
    clock = SimulatedClock(PERIOD)
    return clock, Pipeline(clock, ListSink(), "R1", latency=latency)


def test_a_normal_submission_is_served_only_after_the_latency():
    clock, pipeline = make(0.12)
    ticket = pipeline.submit(Nod(), NORMAL, "leaf")
    seen = []
    for _ in range(5):
        pipeline.settle()
        seen.append(pipeline.top() is ticket)
        clock.advance()
    assert seen == [False, False, False, True, True]  # 0.12 s is over at 0.15 s, the next period
    assert (ticket.submitted, ticket.due) == (0.0, pytest.approx(0.12))


def test_a_whole_number_of_periods_is_that_many_periods():
    clock, pipeline = make(3 * PERIOD)
    clock.advance(7)
    ticket = pipeline.submit(Nod(), NORMAL, "leaf")
    clock.advance(2)
    assert pipeline.top() is None
    clock.advance()
    assert pipeline.top() is ticket


def test_a_running_action_goes_on_while_the_planner_thinks_of_another():
    clock, pipeline = make(0.1)
    old = pipeline.submit(Nod(), NORMAL, "leaf")
    clock.advance(2)
    pipeline.start(pipeline.top())
    assert pipeline.cancel(old, "leaf")
    new = pipeline.submit(Nod(), NORMAL, "leaf")
    clock.advance()
    pipeline.settle()
    assert pipeline.top() is old
    assert old.state is TicketState.RUNNING
    clock.advance()
    pipeline.settle()
    assert (old.state, old.cancelled_by) == (TicketState.CANCELLED, "leaf")
    assert pipeline.top() is new


def test_a_reflex_is_served_at_once_and_cancels_what_is_still_on_its_way():
    clock, pipeline = make(1.0)
    on_its_way = pipeline.submit(Nod(), NORMAL, "leaf")
    reflex = pipeline.submit(Nod(), HIGH, "rules/Flinch")
    assert pipeline.top() is reflex
    assert on_its_way.preempted
    assert pipeline.cancel(reflex, "rules/Flinch")
    assert reflex.state is TicketState.CANCELLED  # at once: reflexes know no latency
    clock.advance(30)
    pipeline.settle()
    assert pipeline.top() is None


def test_a_ticket_that_ended_before_its_cancellation_takes_effect_stays_as_it_ended():
    clock, pipeline = make(0.1)
    ticket = pipeline.submit(Nod(), NORMAL, "leaf")
    clock.advance(2)
    pipeline.start(ticket)
    pipeline.cancel(ticket, "leaf")
    pipeline.succeed(ticket)
    clock.advance(5)
    pipeline.settle()
    assert ticket.state is TicketState.SUCCEEDED


def test_a_measured_latency_is_charged_when_it_is_told():
    clock, pipeline = make(None)
    ticket = pipeline.submit(Nod(), NORMAL, "leaf")
    clock.advance(100)
    assert ticket.due == math.inf
    assert pipeline.top() is None
    pipeline.charge(0.07)
    assert pipeline.top() is None
    clock.advance(2)
    assert pipeline.top() is ticket
    pipeline.charge(10.0)  # of another turn, which decided nothing
    assert pipeline.top() is ticket


@settings(max_examples=200, deadline=None)
@given(
    st.integers(0, 6),
    st.lists(st.sampled_from(["submit", "cancel", "reflex", "serve", "pass"]), max_size=40),
)
def test_with_a_latency_everything_normal_happens_as_without_but_later(periods, steps):
    """Whatever is done, a ticket is never served before it is due, never out of order, and ends exactly once."""
    clock, pipeline = make(periods * PERIOD)
    tickets, ends = [], []
    for step in steps:
        pipeline.settle()
        if step == "submit":
            tickets.append(pipeline.submit(Nod(), NORMAL, "leaf"))
        elif step == "cancel" and tickets:
            pipeline.cancel(tickets[-1], "leaf")
        elif step == "reflex":
            pipeline.succeed(pipeline.submit(Nod(), HIGH, "rule"))
        elif step == "serve" and (top := pipeline.top()) is not None:
            assert clock.now() >= top.due - 1e-9
            assert all(t.state.done for t in tickets[: tickets.index(top)])
            pipeline.start(top)
            pipeline.succeed(top)
            ends.append(top)
        clock.advance()
    clock.advance(10)
    pipeline.settle()
    assert len(ends) == len(set(map(id, ends)))
    assert all(ticket.state.done or ticket in pipeline.queued() for ticket in tickets)


def test_new_values_for_an_action_take_effect_after_the_latency_too():
    clock, pipeline = make(0.1)
    ticket = pipeline.submit(Nod(), NORMAL, "leaf")
    pipeline.update(ticket, {"angle": 0.7})
    pipeline.settle()
    assert ticket.action.angle == 0.3
    clock.advance(), clock.advance()
    pipeline.settle()
    assert ticket.action.angle == 0.7
    pipeline.update(ticket, {"angel": 0.7})
    clock.advance(), clock.advance()
    pipeline.settle()
    assert ticket.failure.reason is Reason.CANNOT


def test_without_a_latency_they_take_effect_at_once():
    _, pipeline = make(0.0)
    ticket = pipeline.submit(Nod(), NORMAL, "leaf")
    pipeline.update(ticket, {"angle": 0.7})
    assert ticket.action.angle == 0.7
