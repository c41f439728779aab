"""One control period after the other: the order of effects, and the guarantee of the reflex route."""

import math

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rocs_bt.analyze import ANALYZERS
from rocs_bt.base.clock import SimulatedClock
from rocs_bt.event import (
    ActuatorCommanded,
    AgentStopped,
    AtomicStarted,
    Change,
    NodeTicked,
    RuleChanged,
    SensorRead,
    SignalsWritten,
    TicketChanged,
)
from rocs_bt.running.header import signals_of
from rocs_bt.testing.mock_agent import mock_rates

PERIOD = 0.05
ENDS = ("SUCCEEDED", "FAILED", "CANCELLED")


def play(agent, stage, ahead, distances):
    """One period for each distance."""
    for distance in distances:
        ahead(distance)
        agent.step(round(stage.clock.now() / PERIOD))
        stage.world.advance(PERIOD)
        stage.clock.advance()


def test_effects_come_in_their_order(make_agent):
    agent, stage, sink, ahead = make_agent(SimulatedClock(PERIOD))
    play(agent, stage, ahead, [math.inf] * 9)
    begin = len(sink.events)
    play(agent, stage, ahead, [math.inf, 0.15])
    kinds = [type(e) for e in sink.events[begin:] if e.t == pytest.approx(10 * PERIOD)]
    places = [
        kinds.index(k)
        for k in (SensorRead, SignalsWritten, RuleChanged, TicketChanged, Change, AtomicStarted, ActuatorCommanded)
    ]
    assert places == sorted(places)
    last = max(i for i, k in enumerate(kinds) if k is SignalsWritten)
    assert last < kinds.index(RuleChanged)  # reflexes see everything that was read in the period
    commands = [e for e in sink.events if isinstance(e, ActuatorCommanded) and e.t == pytest.approx(10 * PERIOD)]
    assert [e.route for e in commands] == ["reactive"]


def test_an_analyser_that_reflexes_read_runs_before_them(make_agent, monkeypatch):
    monkeypatch.setattr(ANALYZERS["PassRange"], "before_reflexes", True)
    agent, stage, sink, ahead = make_agent(SimulatedClock(PERIOD))
    assert [type(analyze).__name__ for analyze in agent.prompt] == ["PassRange"]
    play(agent, stage, ahead, [math.inf] * 9)
    begin = len(sink.events)
    play(agent, stage, ahead, [math.inf, 0.15])
    kinds = [type(e) for e in sink.events[begin:] if e.t == pytest.approx(10 * PERIOD)]
    assert kinds.index(SignalsWritten) < kinds.index(Change) < kinds.index(RuleChanged)
    late = {signal.name for signal in signals_of(agent) if signal.late}
    assert late.isdisjoint(signal.name for analyze in agent.prompt for signal in analyze.signals())


def test_plan_runs_when_it_is_due_or_called_and_not_between(make_agent):
    ticks = []

    def build(mission):
        leaf = mission.act("GoTo", goal="goal")
        update = leaf.update

        def note():
            ticks.append(round(mission.clock.now() / PERIOD))
            return update()

        leaf.update = note
        return leaf

    agent, stage, _, ahead = make_agent(SimulatedClock(PERIOD), build, rates=mock_rates(plan=4.0))
    play(agent, stage, ahead, [math.inf] * 11)
    assert ticks == sorted(ticks)
    assert {0, 5, 10} <= set(ticks)
    before = len(ticks)
    agent.plan.replan("a test")
    play(agent, stage, ahead, [math.inf])
    assert ticks[before:] == [11]
    play(agent, stage, ahead, [0.45])  # an analyser says so
    assert ticks[before:] == [11, 12]


def test_an_agent_that_was_stopped_rests(make_agent):
    agent, stage, sink, ahead = make_agent(SimulatedClock(PERIOD))
    play(agent, stage, ahead, [math.inf] * 30)
    assert any(stage.robot.motion)
    agent.stop("a test")
    agent.stop("a test again")
    assert stage.robot.motion == [0.0, 0.0]
    (stopped,) = [e for e in sink.events if isinstance(e, AgentStopped)]
    assert stopped.by == "a test"
    count = len(sink.events)
    play(agent, stage, ahead, [0.15] * 5)
    assert len(sink.events) == count
    states = {e.ticket: e.state for e in sink.events if isinstance(e, TicketChanged)}
    assert set(states.values()) <= set(ENDS)


def test_a_tree_is_told_from_its_first_tick(make_agent):
    agent, stage, sink, ahead = make_agent(SimulatedClock(PERIOD))
    play(agent, stage, ahead, [math.inf])
    assert [(e.node, e.status) for e in sink.events if isinstance(e, NodeTicked)] == [("GoTo goal", "RUNNING")]
    assert agent.status == "RUNNING"


@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    schedule=st.lists(
        st.tuples(st.sampled_from([math.inf, 0.45, 0.3, 0.15]), st.integers(1, 6)), min_size=1, max_size=12
    )
)
def test_no_high_action_is_lost_overtaken_or_late(schedule, make_agent):
    agent, stage, sink, ahead = make_agent(SimulatedClock(PERIOD))
    play(agent, stage, ahead, [d for d, periods in schedule for _ in range(periods)])
    play(agent, stage, ahead, [math.inf] * 80)  # let all reflexes end
    assert agent.failure is None
    check_guarantee(sink.events)
    running = [
        e.t for e in sink.events if isinstance(e, TicketChanged) and (e.priority, e.state) == ("HIGH", "RUNNING")
    ]
    fired = [e.t for e in sink.events if isinstance(e, RuleChanged) and e.phase in ("fired", "fired again")]
    assert running == fired  # in the very period of the sample, and commanding in it
    reactive = {e.t for e in sink.events if isinstance(e, ActuatorCommanded) and e.route == "reactive"}
    assert set(fired) <= reactive


def check_guarantee(events):
    """No HIGH ticket is lost, and none is overtaken by a NORMAL one."""
    high, ended = set(), set()
    for event in events:
        if isinstance(event, TicketChanged) and event.priority == "HIGH":
            if event.state == "QUEUED":
                high.add(event.ticket)
            elif event.state in ENDS:
                ended.add(event.ticket)
        elif isinstance(event, TicketChanged) and event.state == "RUNNING":
            assert high == ended, f"NORMAL ticket {event.ticket} began while {high - ended} waited or ran"
    assert high == ended
    held = set()
    for event in events:
        if isinstance(event, TicketChanged) and event.priority == "HIGH":
            if event.state == "RUNNING":
                held.add(event.ticket)
            elif event.state in ENDS:
                held.discard(event.ticket)
        elif isinstance(event, ActuatorCommanded) and held:
            assert event.route != "deliberative"
