"""What a change log says of any time is what was: a state read back equals a copy that was replayed by hand."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock, WallClock
from rocs_bt.base.errors import KnowledgeError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import Fanout, KnowledgeChanged, ListSink, NullSink
from rocs_bt.knowledge import Knowledge, KnowledgeGraph
from rocs_bt.knowledge.history import ChangeLog, GraphState, to_json_text

from .worlds import STEPS, WIDE, Step, World, held, naive


@settings(max_examples=80, deadline=None)
@given(before=STEPS, steps=STEPS, keep=st.none() | st.integers(0, 12), asked=st.sets(st.integers(0, 30)))
def test_what_is_read_back_is_a_naive_copy(
    before: list[Step], steps: list[Step], keep: int | None, asked: set[int]
) -> None:
    world = World()
    for step in before:
        world.take(step)
    log = ChangeLog(GraphState.of(world.graph), "run", keep=keep)
    world.sinks.append(log)
    for count, step in enumerate(steps):
        world.take(step)
        if count in asked:
            assert held(log.as_of()) == held(world.graph)
    changes, revision, first = world.changes(), world.graph.revision, log.base.revision
    assert keep is None or len(log.changes) <= keep
    assert list(log.changes) == [c for c in changes if c.revision > first]
    for wanted in (*range(first, revision + 1), *range(revision, first - 1, -1)):  # forwards, and back
        state = log.as_of(revision=wanted)
        assert state.revision == wanted
        assert held(state) == naive(changes, wanted)
    for wanted in (*range(first), revision + 1):
        with pytest.raises(KnowledgeError, match="not kept"):
            log.as_of(revision=wanted)
    for t in {c.t for c in changes if c.t >= log.base.t} | {log.base.t, 1e9}:
        state = log.as_of(t)
        assert state.revision == max((c.revision for c in changes if c.t <= t), default=0)
        assert held(state) == naive(changes, state.revision)
    state = log.as_of()
    assert held(state) == held(world.graph)
    again = GraphState("R2", WIDE)
    for change in log.all_changes():
        again.apply(change)
    assert held(again) == held(state)
    if not before and changes:
        check_stamps(state, changes)
        recorded = ChangeLog(GraphState("R2", WIDE), "run", changes)
        assert to_json_text(recorded.as_of()) == to_json_text(state)


def check_stamps(state: GraphState, changes: list[KnowledgeChanged]) -> None:
    """That stamps are those of the newest change."""
    about = [c for c in changes if c.what in ("node added", "attribute")]
    for node in state.nodes():
        born = max(c.revision for c in about if c.subject == node and c.what == "node added")
        newest = [c for c in about if c.subject == node and c.revision >= born][-1]
        assert state.stamp(node) == (newest.t, newest.revision)
        for attribute, stamp in state.written(node).items():
            last = [c for c in about if (c.subject, c.name) == (node, attribute) and c.what == "attribute"][-1]
            assert stamp == (last.t, last.revision)


def test_the_past_of_a_run_that_goes_on() -> None:
    clock = SimulatedClock(0.05)
    knowledge = Knowledge("R2", clock, NullSink())
    for count in range(10):
        knowledge.world.place("box", Pose2(count, 0.0), "object")
        clock.advance()
    past = knowledge.past
    assert past.as_of(0.21).get("box", "pose").x == 4.0
    earlier = past.as_of(0.31)  # an answer stays as it is when later ones build on it
    assert past.as_of(0.41).get("box", "pose").x == 8.0
    assert earlier.get("box", "pose").x == 6.0
    assert past.as_of(0.11).get("box", "pose").x == 2.0
    assert knowledge.holds("object where pose.x == 2 m as of 0.11 s")
    assert not past.as_of(-1.0).nodes()
    assert held(past.as_of(10.0)) == held(knowledge.graph)


def test_threads_may_ask_while_others_write() -> None:
    log, sink = ChangeLog(GraphState("R2"), keep=50), ListSink()
    graph = KnowledgeGraph(WallClock(), Fanout(sink, log), "R2")
    graph.add("box", "object", radius=0.0)

    def write(name: str) -> None:
        for count in range(200):
            graph.add(f"{name}{count}", "object", radius=1.0)
            graph.relate(f"{name}{count}", "near", "box")
            graph.remove(f"{name}{count}")

    before = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    try:
        with ThreadPoolExecutor(5) as pool:
            writers = [pool.submit(write, name) for name in "abc"]
            askers = [pool.submit(lambda: [log.as_of() for _ in range(10)]) for _ in range(2)]
            for writer in writers:
                writer.result()
            states = [state for asker in askers for state in asker.result()]
    finally:
        sys.setswitchinterval(before)
    for state in (*states, log.as_of()):
        assert held(state) == naive([e for e in sink.events if isinstance(e, KnowledgeChanged)], state.revision)
    assert held(log.as_of()) == held(graph)
