"""A glance at an earlier revision tells what the whole state of it does, and reads no more than it must."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.clock import SimulatedClock
from rocs_bt.errors import KnowledgeError
from rocs_bt.event import NullSink
from rocs_bt.geometry import Pose2
from rocs_bt.knowledge import KnowledgeGraph, Readable
from rocs_bt.knowledge.history import History, Journal, JournalPast, State

from .worlds import STEPS, WIDE, Step, World, held


def told(graph: Readable) -> dict[str, Any]:
    """All that can be asked of a graph, in the order in which it answers."""
    nodes = graph.nodes()
    return {
        **held(graph),
        "revision": graph.revision,
        "stamps": {
            (n, a): graph.stamp(n, a) for n in nodes for a in (None, *graph.schema.kinds[graph.kind(n)].attributes)
        },
        "rows": {n: (graph.row(n) or {})["revision"] for n in nodes},
        "targets": [(n, r, t, row["t"], row["revision"]) for n in nodes for r in ("brushes", "grips")
                    for t, row in graph.targets(n, r).items()],
        "sources": [(n, r, s, row["t"], row["revision"]) for n in nodes for r in ("brushes", "grips")
                    for s, row in graph.sources(n, r).items()],
        "kinds": (graph.nodes("specimen"), graph.nodes("object")),
        "changed": graph.changed_since(graph.revision // 2),
        "near": list(graph.by_distance(0.0, 0.0)),
    }  # fmt: skip


@settings(max_examples=60, deadline=None)
@given(before=STEPS, steps=STEPS, keep=st.integers(0, 12) | st.just(1000))
def test_any_time_reads_as_the_whole_state_does(before: list[Step], steps: list[Step], keep: int) -> None:
    with TemporaryDirectory() as folder:
        path, world = Path(folder) / "k.sqlite", World()
        for step in before:
            world.take(step)
        with Journal(path, keep=keep, patient=True, every=60.0) as journal:
            journal.attach(world.graph)
            past = JournalPast(journal, world.graph)
            for step in steps:
                world.take(step)
            journal.flush()
            with History(path, schema=WIDE) as history:
                times = {c.t for c in history.changes()} | {history.first.begin, history.last.end, 1e9}
                for t in sorted(times):
                    glance = past.as_of(t)
                    assert told(glance) == told(history.as_of(t))
                    assert told(glance) == told(glance.whole())
            past.close()


def test_what_is_folded_meanwhile_is_refused_and_what_was_read_stays(tmp_path: Path) -> None:
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")
    for name in ("box", "can"):
        graph.add(name, "object", radius=0.1)
    with Journal(tmp_path / "k.sqlite", keep=2, patient=True, every=60.0) as journal:
        journal.attach(graph)
        past = JournalPast(journal, graph)
        graph.set("box", radius=0.2)
        glance = past.as_of(1.0)
        assert glance.get("box", "radius") == 0.2
        for count in range(5):
            graph.set("box", radius=1.0 + count)
        journal.flush()
        assert glance.get("box", "radius") == 0.2
        with pytest.raises(KnowledgeError, match="is not kept any more"):
            glance.get("can", "radius")
        past.close()


def test_only_who_asks_for_many_nodes_is_given_the_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")
    for count in range(600):
        graph.add(f"o{count}", "object", pose=Pose2(float(count), 0.0))
    taken = []
    whole = History.as_of

    def counted(history: History, *args: Any, **given: Any) -> State:
        taken.append(given)
        return whole(history, *args, **given)

    monkeypatch.setattr(History, "as_of", counted)
    with Journal(tmp_path / "k.sqlite", patient=True, every=60.0) as journal:
        journal.attach(graph)
        past = JournalPast(journal, graph)
        glance = past.as_of(1.0)
        assert glance.get("o7", "pose").x == 7.0
        assert len(glance.nodes("object")) == 600
        assert not glance.has("o600")
        assert not taken
        assert [name for _, name in glance.by_distance(8.2, 0.0, "object", 1.0)] == ["o8", "o9"]
        assert len(taken) == 1
        assert glance.get("o7", "pose").x == 7.0
        past.close()
