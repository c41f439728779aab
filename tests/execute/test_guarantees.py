"""The guarantees of pre-emption, on random schedules: submissions of both priorities, cancellations, holds."""

from collections import Counter

from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.event import TicketChanged
from rocs_bt.interfaces.action import Failure, Reason
from rocs_bt.interfaces.pipeline import Priority, TicketState

atom = st.fixed_dictionaries(
    {"periods": st.integers(1, 4), "mute": st.booleans(), "fails": st.booleans(), "nested": st.booleans()}
)
operation = st.one_of(
    st.tuples(st.just("normal"), st.lists(atom, min_size=1, max_size=3)),
    st.tuples(st.just("high"), st.lists(atom, min_size=1, max_size=3)),
    st.tuples(st.just("cancel"), st.integers(0, 50)),
    st.tuples(st.just("hold"), st.booleans()),
)
schedule = st.lists(st.lists(operation, max_size=3), min_size=1, max_size=12)


class Run:
    """One schedule, carried out; then whatever is left is given time to end."""

    def __init__(self, bench, make_do, make_chain, plan):
        self.bench, self.make_do, self.make_chain = bench, make_do, make_chain
        self.tickets, self.cancelled = [], set()
        self.periods = []  # (tickets queued before the period, what happened in it)
        for operations in plan:
            for kind, value in operations:
                getattr(self, kind)(value)
            self.period()
        self.hold(False)
        while self.bench.pipeline.queued():
            self.period()
        self.period()

    def period(self):
        queued = self.bench.pipeline.queued()
        self.periods.append((queued, self.bench.run()))

    def normal(self, atoms, priority=Priority.NORMAL):
        label = str(len(self.tickets))
        self.tickets.append(self.bench.pipeline.submit(self.make(label, atoms), priority, by=label))

    def high(self, atoms):
        self.normal(atoms, Priority.HIGH)

    def cancel(self, index):
        if self.tickets:
            ticket = self.tickets[index % len(self.tickets)]
            if self.bench.pipeline.cancel(ticket, "somebody"):
                self.cancelled.add(ticket)

    def hold(self, held):
        self.bench.pipeline.hold(held)

    def make(self, label, atoms):
        steps = []
        for atom in atoms:
            failure = Failure(Reason.BLOCKED, label) if atom["fails"] else None
            step = self.make_do(
                label=label, log=self.bench.log, periods=atom["periods"], mute=atom["mute"], ends=failure
            )
            steps.append(self.make_chain(label=label, log=[], steps=[step]) if atom["nested"] else step)
        return steps[0] if len(steps) == 1 else self.make_chain(label=label, log=[], steps=steps)

    def acts(self, ticket):
        label = str(self.tickets.index(ticket))
        return [i for i, (_, log) in enumerate(self.periods) if ("act", label) in log]


def every_ticket_ends_exactly_once(run):
    ends = Counter()
    for event in run.bench.sink.events:
        if isinstance(event, TicketChanged) and TicketState(event.state).done:
            ends[event.ticket] += 1
    assert ends == {t.number: 1 for t in run.tickets}


def no_high_action_is_lost(run):
    for ticket in run.tickets:
        if ticket.priority is Priority.HIGH and ticket not in run.cancelled:
            assert ticket.state in (TicketState.SUCCEEDED, TicketState.FAILED)
            assert run.acts(ticket)


def a_high_action_acts_in_the_period_of_its_submission(run):
    first = {}  # the period before which a HIGH ticket was submitted, or came to the head of the others
    for i, (queued, _) in enumerate(run.periods):
        if queued and queued[0].priority is Priority.HIGH:
            first.setdefault(queued[0], i)
    for ticket, period in first.items():
        assert run.acts(ticket)[0] <= period


def no_normal_action_overtakes_a_high_one(run):
    for _, log in run.periods:
        labels = [label for what, label, *_ in (e for e in log if e[0] == "act")]
        priorities = [run.tickets[int(label)].priority for label in labels]
        assert priorities == sorted(priorities, key=lambda p: -p.value)


def each_priority_is_first_in_first_out(run):
    for priority in Priority:
        order = [run.acts(t)[0] for t in run.tickets if t.priority is priority and run.acts(t)]
        assert order == sorted(order)


def stop_comes_exactly_once_and_before_anything_else_acts(run):
    log = run.bench.log
    for number, ticket in enumerate(run.tickets):
        label = str(number)
        stops = [i for i, e in enumerate(log) if e == ("stop", label)]
        acts = [i for i, e in enumerate(log) if e == ("act", label)]
        if ticket.state is not TicketState.CANCELLED or not acts:
            assert not stops
            continue
        assert len(stops) <= 1  # none where the last atomic action had just ended
        later = [e for e in log[acts[-1] + 1 :] if e[0] == "act"]
        if stops and later:
            assert stops[0] < log.index(later[0], acts[-1] + 1)


def the_wheels_rest_when_nothing_commands(run):
    moving = False
    for _, log in run.periods:
        commands = [e for e in log if e[0] == "command"]
        if log and log[-1][0] == "neutral":
            moving = False
        elif commands:
            moving = True
        else:
            assert not moving
    assert not run.bench.wheels.moving


def one_action_commands_in_a_period(run):
    for _, log in run.periods:
        assert [e[0] for e in log].count("command") <= 1


GUARANTEES = (
    every_ticket_ends_exactly_once,
    no_high_action_is_lost,
    a_high_action_acts_in_the_period_of_its_submission,
    no_normal_action_overtakes_a_high_one,
    each_priority_is_first_in_first_out,
    stop_comes_exactly_once_and_before_anything_else_acts,
    the_wheels_rest_when_nothing_commands,
    one_action_commands_in_a_period,
)


@settings(max_examples=200, deadline=None)
@given(plan=schedule)
def test_the_guarantees_hold_on_any_schedule(make_bench, make_do, make_chain, plan):
    run = Run(make_bench(), make_do, make_chain, plan)
    for guarantee in GUARANTEES:
        guarantee(run)
