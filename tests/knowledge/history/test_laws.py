"""What the journal keeps is what was: any revision read back equals a copy that was replayed by hand."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.errors import KnowledgeError
from rocs_bt.knowledge.history import History, Journal, to_json_text

from .worlds import STEPS, WIDE, Step, World, held, naive


@settings(max_examples=60, deadline=None)
@given(before=STEPS, steps=STEPS, keep=st.integers(0, 12) | st.just(1000), flushes=st.sets(st.integers(0, 30)))
def test_any_revision_reads_as_a_naive_copy(
    before: list[Step], steps: list[Step], keep: int, flushes: set[int]
) -> None:
    with TemporaryDirectory() as folder:
        path, world = Path(folder) / "k.sqlite", World()
        for step in before:
            world.take(step)
        with Journal(path, keep=keep, patient=True, every=60.0) as journal:
            journal.attach(world.graph)
            for count, step in enumerate(steps):
                world.take(step)
                if count in flushes:
                    journal.flush()
        changes, revision = world.changes(), world.graph.revision
        with History(path, schema=WIDE) as history:
            assert revision - history.first.first <= keep
            assert history.last.last == revision
            for wanted in range(history.first.first, revision + 1):
                assert held(history.as_of(revision=wanted)) == naive(changes, wanted)
            for wanted in range(history.first.first):
                with pytest.raises(KnowledgeError, match="not kept"):
                    history.as_of(revision=wanted)
            assert held(history.as_of()) == held(world.graph)
            last = to_json_text(history.as_of())
            with History(path, schema=WIDE) as again:  # without a state that was asked for before
                assert to_json_text(again.as_of()) == last
            assert list(history.changes()) == [c for c in changes if c.revision > history.first.first]


@settings(max_examples=40, deadline=None)
@given(steps=STEPS, keep=st.integers(0, 12) | st.just(1000))
def test_any_time_and_any_value_reads_as_a_naive_copy(steps: list[Step], keep: int) -> None:
    with TemporaryDirectory() as folder:
        path, world = Path(folder) / "k.sqlite", World()
        with Journal(path, keep=keep, patient=True, every=60.0) as journal:
            journal.attach(world.graph)
            for step in steps:
                world.take(step)
        changes = world.changes()
        with History(path, schema=WIDE) as history:
            for t in {c.t for c in changes if c.t >= history.first.begin} | {history.first.begin, 1e9}:
                newest = max((c.revision for c in changes if c.t <= t), default=0)
                state = history.as_of(t)
                assert state.revision == newest
                assert held(state) == naive(changes, newest)
                for node in state.nodes():
                    for attribute in state.schema.kinds[state.kind(node)].attributes:
                        assert history.value(node, attribute, t) == state.get(node, attribute)


@settings(max_examples=40, deadline=None)
@given(steps=STEPS)
def test_stamps_tell_of_the_newest_change(steps: list[Step]) -> None:
    with TemporaryDirectory() as folder:
        path, world = Path(folder) / "k.sqlite", World()
        with Journal(path, keep=7, patient=True, every=60.0) as journal:
            journal.attach(world.graph)
            for step in steps:
                world.take(step)
        with History(path, schema=WIDE) as history:
            state = history.as_of()
        about = [c for c in world.changes() if c.what in ("node added", "attribute")]
        for node in state.nodes():
            born = max(c.revision for c in about if c.subject == node and c.what == "node added")
            newest = [c for c in about if c.subject == node and c.revision >= born][-1]
            assert state.stamp(node) == (newest.t, newest.revision)
            for attribute, stamp in state.written(node).items():
                last = [c for c in about if (c.subject, c.name) == (node, attribute) and c.what == "attribute"][-1]
                assert stamp == (last.t, last.revision)
