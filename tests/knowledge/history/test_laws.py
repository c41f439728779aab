"""What the journal keeps is what was: any revision read back equals a copy that was replayed by hand."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.errors import KnowledgeError
from rocs_bt.event import KnowledgeChanged
from rocs_bt.knowledge.history import History, Journal, State, to_json_text

from .worlds import STEPS, WIDE, Step, World, held, naive


@settings(max_examples=80, deadline=None)
@given(before=STEPS, steps=STEPS, keep=st.integers(0, 12) | st.just(1000), flushes=st.sets(st.integers(0, 30)))
def test_what_is_read_back_is_a_naive_copy(before: list[Step], steps: list[Step], keep: int, flushes: set[int]) -> None:
    with TemporaryDirectory() as folder:
        path, world = Path(folder) / "k.sqlite", World()
        for step in before:
            world.take(step)
        with Journal(path, keep=keep, blocking=True, every=60.0) as journal:
            journal.attach(world.graph)
            for count, step in enumerate(steps):
                world.take(step)
                if count in flushes:
                    journal.flush()
        changes, revision = world.changes(), world.graph.revision
        with History(path, schema=WIDE) as history:
            first = history.first.first
            assert revision - first <= keep
            assert history.last.last == revision
            assert list(history.changes()) == [c for c in changes if c.revision > first]
            for wanted in range(first, revision + 1):
                assert held(history.as_of(revision=wanted)) == naive(changes, wanted)
            for wanted in range(first):
                with pytest.raises(KnowledgeError, match="not kept"):
                    history.as_of(revision=wanted)
            for t in {c.t for c in changes if c.t >= history.first.begin} | {history.first.begin, 1e9}:
                check_at(history, changes, t)
            state = history.as_of()
            assert held(state) == held(world.graph)
        with History(path, schema=WIDE) as again:  # without the states in between
            assert to_json_text(again.as_of()) == to_json_text(state)
        if not before:
            check_stamps(state, changes)


def check_at(history: History, changes: list[KnowledgeChanged], t: float) -> None:
    """That state and single values at a time are those of the newest change up to then."""
    state = history.as_of(t)
    assert state.revision == max((c.revision for c in changes if c.t <= t), default=0)
    assert held(state) == naive(changes, state.revision)
    for node in state.nodes():
        for attribute in state.schema.kinds[state.kind(node)].attributes:
            assert history.value(node, attribute, t) == state.get(node, attribute)


def check_stamps(state: State, changes: list[KnowledgeChanged]) -> None:
    """That stamps are those of the newest change."""
    about = [c for c in changes if c.what in ("node added", "attribute")]
    for node in state.nodes():
        born = max(c.revision for c in about if c.subject == node and c.what == "node added")
        newest = [c for c in about if c.subject == node and c.revision >= born][-1]
        assert state.stamp(node) == (newest.t, newest.revision)
        for attribute, stamp in state.written(node).items():
            last = [c for c in about if (c.subject, c.name) == (node, attribute) and c.what == "attribute"][-1]
            assert stamp == (last.t, last.revision)
