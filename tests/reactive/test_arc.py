"""What the one reflex slot guarantees, on random traces and by example."""

import math
import threading

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.units import PositiveRadiansPerSecond, Radians
from rocs_bt.event import ListSink, RuleChanged
from rocs_bt.interfaces.action import AtomicAction, Failure, Progress, Reason
from rocs_bt.interfaces.pipeline import Pipeline, Priority, TicketState
from rocs_bt.reactive import ReactiveModel, Reflex, ReflexArc

X = np.zeros(1)
LEVELS = {"a": 1, "b": 1, "c": 2, "d": 3}
KINDS = {"a": False, "b": True, "c": False, "d": True}


class Work(AtomicAction):
    """Works."""

    angle: Radians = 0.0
    rate: PositiveRadiansPerSecond = 1.0

    def act(self, body):
        return Progress.RUNNING


class Script(ReactiveModel):
    """Wants what the test says."""

    def __init__(self):
        self.wanted = []

    def react(self, x, t):
        return self.wanted


def reflex(rule, **more):
    return Reflex(**({"rule": rule, "priority": LEVELS[rule], "action": "Work", "level": KINDS[rule]} | more))


class Bench:
    """An arc between a script and a pipeline."""

    def __init__(self):
        self.clock = SimulatedClock(0.05)
        self.sink = ListSink()
        self.pipeline = Pipeline(self.clock, self.sink, "R")
        self.script = Script()
        self.arc = ReflexArc([self.script], self.pipeline, {"Work": Work}, self.sink, "R", self.clock)
        self.ends = []
        self.arc.on_end = self.ends.append

    def step(self, *wanted):
        """One snapshot on which these rules are latched."""
        self.script.wanted = [reflex(w) if isinstance(w, str) else w for w in wanted]
        self.arc.run(X, self.clock.now())
        self.clock.advance()
        return self.pipeline.top()

    def phases(self, rule=None):
        return [e.phase for e in self.sink.events if isinstance(e, RuleChanged) and rule in (None, e.rule)]


steps = st.lists(
    st.tuples(
        st.lists(st.sampled_from(sorted(LEVELS)), unique=True),
        st.sampled_from(["go on", "go on", "succeed", "fail"]),
        st.booleans(),
    ),
    max_size=40,
)


@settings(max_examples=400, deadline=None)
@given(steps)
def test_guarantees(trace):
    """The slot against its plain description, after every snapshot of a random trace."""
    bench = Bench()
    active, running, fired, refired, ends = None, False, 0, 0, 0
    for wanted, outcome, normal in trace:
        top = bench.step(*wanted)
        if active and KINDS[active] and active not in wanted:
            running = False
        rank = sorted(wanted, key=lambda r: -LEVELS[r])
        if active and not running and active not in wanted:
            active = None
            ends += not wanted
        if active and rank and LEVELS[rank[0]] > LEVELS[active]:
            active, running, fired = rank[0], True, fired + 1
        elif active and not running:
            running, refired = True, refired + 1
        elif not active and rank:
            first = next(w for w in wanted if LEVELS[w] == LEVELS[rank[0]])
            active, running, fired = first, True, fired + 1
        assert bench.arc.active == active
        assert bench.pipeline.held is (active is not None)
        counts = bench.arc.activations.total(), bench.arc.refirings.total(), len(bench.ends)
        assert counts == (fired, refired, ends)
        high = [t for t in bench.pipeline.queued() if t.priority is Priority.HIGH]
        assert len(high) == running
        if running:
            assert top is high[0]
            assert top.by == active
        elif active:
            assert top is None
        assert all(LEVELS[w] <= LEVELS[active] for w in wanted)
        if top is not None:
            bench.pipeline.start(top)
            if outcome == "succeed":
                bench.pipeline.succeed(top)
            elif outcome == "fail":
                bench.pipeline.fail(top, Failure(Reason.OTHER))
            running = running and outcome == "go on"
        if normal:
            bench.pipeline.submit(Work(), Priority.NORMAL, "leaf")
    for rule in LEVELS:
        told = [p for p in bench.phases(rule) if p in ("latched", "released")]
        assert told == ["latched", "released"] * (len(told) // 2) + ["latched"] * (len(told) % 2)
    assert (bench.phases().count("fired"), bench.phases().count("fired again")) == (fired, refired)


def test_a_reflex_clears_normal_actions_and_ends_when_action_and_latch_have():
    bench = Bench()
    normal = bench.pipeline.submit(Work(), Priority.NORMAL, "leaf")
    ticket = bench.step("a")
    assert (normal.state, normal.cancelled_by) == (TicketState.CANCELLED, "a")
    waiting = bench.pipeline.submit(Work(), Priority.NORMAL, "leaf")
    assert bench.step() is ticket
    assert bench.ends == []
    bench.pipeline.succeed(ticket)
    assert bench.pipeline.top() is None
    assert bench.step() is waiting
    assert bench.ends == ["a"]
    assert bench.phases() == ["latched", "fired", "released", "ended"]
    assert bench.arc.switches == 2


def test_an_action_that_ends_while_latched_fires_again():
    bench = Bench()
    bench.pipeline.succeed(bench.step("a"))
    assert bench.step("a").state is TicketState.QUEUED
    assert bench.phases() == ["latched", "fired", "fired again"]
    assert (bench.arc.activations["a"], bench.arc.refirings["a"], bench.arc.switches) == (1, 1, 1)


def test_the_reading_of_a_rule_counts_the_failures_of_its_action():
    bench, failed = Bench(), []
    for count in range(1, 5):
        bench.pipeline.fail(bench.step(reflex("a", reading="x = 1 m")), Failure(Reason.BLOCKED, "no room"))
        failed.append(f"; its action Work failed {count} times: BLOCKED: no room" if count > 1 else "")
        assert bench.arc.reading("a") == f"x = 1 m{failed[-1]}"
    bench.step()  # the activation ends
    assert bench.arc.reading("a") == f"x = 1 m{failed[-1]}"
    bench.step(reflex("a", reading="x = 2 m"))
    assert bench.arc.reading("a") == "x = 2 m"


def test_each_event_has_the_refirings_of_its_activation():
    bench = Bench()
    for _ in range(3):
        bench.pipeline.succeed(bench.step("a"))
    bench.step()
    bench.step("a")
    told = [(e.phase, e.refirings) for e in bench.sink.events if isinstance(e, RuleChanged)]
    assert told == [
        ("latched", 0),
        ("fired", 0),
        ("fired again", 1),
        ("fired again", 2),
        ("released", 2),
        ("ended", 2),
        ("latched", 0),
        ("fired", 0),
    ]


def test_level_is_cancelled_on_release_and_edge_is_not():
    for rule, state in (("b", TicketState.CANCELLED), ("a", TicketState.QUEUED)):
        bench = Bench()
        ticket = bench.step(rule)
        bench.step()
        assert ticket.state is state
        assert bench.arc.active == (None if KINDS[rule] else rule)


def test_a_strictly_higher_one_takes_the_slot_and_the_lower_one_waits_for_it():
    bench = Bench()
    low = bench.step("a")
    high = bench.step("a", "d")
    assert (low.state, low.cancelled_by, high.by) == (TicketState.CANCELLED, "d", "d")
    assert bench.step("a").by == "a"
    assert bench.phases("a") == ["latched", "fired", "ended", "waits", "fired"]
    assert bench.ends == []


def test_an_equal_one_starts_only_if_it_is_still_wanted():
    bench = Bench()
    first = bench.step("a")
    assert bench.step("a", "b") is first
    assert bench.step("a") is first
    bench.pipeline.succeed(first)
    assert bench.step() is None
    assert bench.phases("b") == ["latched", "waits", "released"]
    bench.step("a")
    for wanted in (["a", "b"], ["a"], ["a", "b"]):
        bench.step(*wanted)
    assert bench.phases("b")[3:] == ["latched", "waits", "released", "latched", "waits"]


def test_a_rule_whose_action_is_active_updates_it():
    bench = Bench()
    ticket = bench.step(reflex("a", parameters={"angle": 1.0}))
    for angle in (1.01, 1.02, 1.2):
        assert bench.step(reflex("a", parameters={"angle": angle})) is ticket
        assert ticket.action.angle == angle
    assert bench.phases() == ["latched", "fired", "updated"]


def test_a_reflex_that_comes_out_impossible_clears_the_way_and_fails_and_the_arc_goes_on():
    bench = Bench()
    normal = bench.pipeline.submit(Work(), Priority.NORMAL, "leaf")
    for rate, bound in ((-1.0, "positive"), (math.inf, "finite")):
        ticket = bench.step(reflex("a", parameters={"rate": rate}))
        assert normal.cancelled_by == "a"
        assert bench.pipeline.held
        assert (ticket.priority, ticket.action.name, ticket.action.parameters) == (
            Priority.HIGH,
            "Work",
            {"rate": rate},
        )
        bench.pipeline.start(ticket)
        failure = ticket.action.act(None)
        assert str(failure) == f"CANNOT: rate of Work must be {bound}, found {rate:g} rad/s."
        bench.pipeline.fail(ticket, failure)
    ticket = bench.step(reflex("a", parameters={"rate": 2.0}))
    assert (ticket.action.rate, ticket.state) == (2.0, TicketState.QUEUED)
    assert bench.phases() == ["latched", "fired", "fired again", "fired again"]


def test_so_does_one_that_becomes_impossible_while_it_acts():
    bench = Bench()
    ticket = bench.step(reflex("a", parameters={"rate": 2.0}))
    bench.pipeline.start(ticket)
    assert bench.pipeline.wait(0.0)
    assert not bench.pipeline.wait(0.0)
    assert bench.step(reflex("a", parameters={"rate": 0.0})) is None
    assert ticket.state is TicketState.FAILED
    assert str(ticket.failure) == "CANNOT: rate of Work must be positive, found 0 rad/s."
    assert ticket.action.rate == 2.0
    assert bench.pipeline.wait(0.0)  # Execute is called, or the wheels would turn on until it comes by
    again = bench.step(reflex("a", parameters={"rate": 2.0}))
    assert again is not ticket
    assert again.state is TicketState.QUEUED


def test_an_unknown_action_of_a_model_in_python_fails_too():
    bench = Bench()
    ticket = bench.step(reflex("a", action="Wrok"))
    assert str(ticket.action.act(None)).startswith("CANNOT: no action is named 'Wrok'. Did you mean 'Work'?")


def test_readings_are_built_for_events_alone():
    bench, built = Bench(), []
    wish = reflex("a", reading=lambda: built.append(1) or "front = 0.2 m")
    for _ in range(5):
        bench.step(wish)
    assert len(built) <= 3
    assert bench.arc.reading("a") == "front = 0.2 m"
    assert bench.arc.reading("never") == ""


def test_a_snapshot_that_was_overtaken_is_ignored_but_a_new_time_is_not():
    bench = Bench()
    bench.script.wanted = [reflex("a")]
    bench.arc.run(X, 10.0)
    bench.script.wanted = []
    bench.arc.run(X, 9.9)
    assert bench.phases() == ["latched", "fired"]
    bench.arc.run(X, 0.0)
    assert bench.phases() == ["latched", "fired", "released"]


def test_threads_share_the_one_slot():
    """Two monitors' threads and one that executes: each ticket ends once, and never are two reflexes queued."""
    bench, crowded, stop = Bench(), [], threading.Event()

    class Flicker(ReactiveModel):
        def react(self, x, t):
            return [reflex(r) for i, r in enumerate(LEVELS) if math.sin(7.3 * t + i) > 0.0]

    arc = ReflexArc([Flicker()], bench.pipeline, {"Work": Work}, bench.sink, "R", bench.clock)

    def monitor(offset):
        for i in range(400):
            arc.run(X, 0.01 * i + offset)

    def execute():
        while not stop.is_set():
            if ticket := bench.pipeline.top():
                bench.pipeline.start(ticket)
                bench.pipeline.succeed(ticket)
            high = [t for t in bench.pipeline.queued() if t.priority is Priority.HIGH]
            # For the moment between submit and cancel of a pre-emption two are queued, never more.
            crowded.append(len(high))

    threads = [threading.Thread(target=monitor, args=(o,)) for o in (0.0, 0.005)]
    worker = threading.Thread(target=execute)
    worker.start()
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    stop.set()
    worker.join()
    assert max(crowded) <= 2
    queued = sum(1 for e in bench.sink.events if getattr(e, "state", "") == "QUEUED")
    assert arc.activations.total() + arc.refirings.total() == queued
    assert bench.pipeline.held is (arc.active is not None)
