from __future__ import annotations

import threading
from collections.abc import Callable

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import KnowledgeChanged, ListSink, SubscriberDetached
from rocs_bt.knowledge import KnowledgeGraph

HERE = Pose2(0.0, 0.0)


@pytest.fixture
def graph(clock: SimulatedClock, sink: ListSink) -> KnowledgeGraph:
    made = KnowledgeGraph(clock, sink, "R2")
    made.add("R2", "robot")
    made.add("home", "goal", pose=HERE)
    made.add("box", "object")
    return made


@pytest.mark.parametrize(
    ("filters", "heard"),
    [
        ({}, ["radius", "tolerance", "near", "pursues", "near", "object"]),
        ({"kind": "object"}, ["radius", "near", "near", "object"]),
        ({"kind": "goal"}, ["tolerance", "pursues"]),
        ({"node": "box"}, ["radius", "near", "near", "object"]),
        ({"node": "R2"}, ["near", "pursues", "near"]),
        ({"relation": "near"}, ["near", "near"]),
        ({"relation": "near", "node": "home"}, []),
        ({"kind": "goal", "relation": "pursues", "node": "R2"}, ["pursues"]),
    ],
)
def test_a_subscriber_hears_exactly_what_fits_all_its_filters(
    graph: KnowledgeGraph, filters: dict[str, str], heard: list[str]
) -> None:
    changes: list[KnowledgeChanged] = []
    graph.subscribe(changes.append, **filters)
    graph.set("box", radius=0.5)
    graph.set("home", tolerance=0.2)
    graph.relate("R2", "near", "box")
    graph.relate("R2", "pursues", "home")
    graph.remove("box")
    assert [c.name for c in changes] == heard


def test_a_node_may_be_awaited_before_it_exists(graph: KnowledgeGraph) -> None:
    changes: list[KnowledgeChanged] = []
    graph.subscribe(changes.append, node="ball")
    graph.add("ball", "object", radius=0.1)
    assert [(c.what, c.name) for c in changes] == [("node added", "object"), ("attribute", "radius")]


def test_subscribers_hear_in_the_order_in_which_they_came(graph: KnowledgeGraph) -> None:
    heard: list[tuple[str, str]] = []
    for name in ("first", "second", "third"):
        graph.subscribe(lambda c, name=name: heard.append((name, c.name)), node="box")
    graph.set("box", radius=0.5, height=0.5)
    assert heard == [(s, a) for a in ("radius", "height") for s in ("first", "second", "third")]


def test_a_closed_subscription_hears_no_more(graph: KnowledgeGraph) -> None:
    changes: list[KnowledgeChanged] = []
    subscription = graph.subscribe(changes.append)
    graph.set("box", radius=0.5)
    assert subscription.active
    subscription.close()
    subscription.close()
    graph.set("box", radius=0.6)
    assert [c.value for c in changes] == [0.5]
    assert not subscription.active


def test_one_that_another_subscriber_closes_does_not_hear_that_change(graph: KnowledgeGraph) -> None:
    changes: list[KnowledgeChanged] = []
    graph.subscribe(lambda c: second.close(), node="box")
    second = graph.subscribe(changes.append, node="box")
    graph.set("box", radius=0.5)
    assert changes == []


def test_the_change_is_readable_when_it_is_heard(graph: KnowledgeGraph) -> None:
    seen: list[object] = []
    graph.subscribe(lambda c: seen.append(graph.get("box", "radius")), node="box")
    graph.set("box", radius=0.5)
    assert seen == [0.5]


def test_the_writers_lock_is_free_while_subscribers_hear(graph: KnowledgeGraph) -> None:
    done: list[bool] = []

    def let_another_thread_write(change: KnowledgeChanged) -> None:
        other = threading.Thread(target=lambda: graph.set("home", tolerance=0.7))
        other.start()
        other.join(timeout=10.0)
        done.append(not other.is_alive())

    graph.subscribe(let_another_thread_write, node="box")
    graph.set("box", radius=0.5)
    assert done == [True]
    assert graph.get("home", "tolerance") == 0.7


def test_a_write_inside_a_callback_is_told_after_the_change_that_caused_it(graph: KnowledgeGraph) -> None:
    heard: list[tuple[str, int]] = []

    def answer(change: KnowledgeChanged) -> None:
        heard.append(("answer", change.revision))
        if change.subject == "box":
            graph.set("home", tolerance=0.5)

    graph.subscribe(answer)
    graph.subscribe(lambda c: heard.append(("listen", c.revision)))
    first = graph.revision + 1
    graph.set("box", radius=0.5)
    assert heard == [("answer", first), ("listen", first), ("answer", first + 1), ("listen", first + 1)]


def test_one_that_raises_is_detached_and_reported_and_harms_nobody(graph: KnowledgeGraph, sink: ListSink) -> None:
    heard: list[float] = []
    failure = ValueError("no idea")

    def broken(change: KnowledgeChanged) -> None:
        raise failure

    subscription = graph.subscribe(broken)
    graph.subscribe(lambda c: heard.append(c.value))
    graph.set("box", radius=0.5)
    graph.set("box", radius=0.6)
    assert heard == [0.5, 0.6]
    assert not subscription.active
    (report,) = graph.failures
    assert report.error is failure
    assert report.change.value == 0.5
    (event,) = [e for e in sink.events if isinstance(e, SubscriberDetached)]
    assert event.callback.endswith("broken")
    assert (event.detail, event.revision, event.agent) == ("ValueError: no idea", report.change.revision, "R2")


def test_changes_made_while_holding_are_told_at_the_end(graph: KnowledgeGraph) -> None:
    changes: list[KnowledgeChanged] = []
    graph.subscribe(changes.append)
    with graph.locked() as view, graph.locked():
        graph.set("box", radius=0.5)
        graph.set("home", tolerance=0.5)
        assert view.nodes["box"]["radius"] == 0.5
        assert changes == []
    assert [c.subject for c in changes] == ["box", "home"]


def test_changes_made_before_an_error_while_holding_are_told_too(graph: KnowledgeGraph) -> None:
    changes: list[KnowledgeChanged] = []
    graph.subscribe(changes.append)

    def fail() -> None:
        with graph.locked():
            graph.set("box", radius=0.5)
            raise RuntimeError("half-way")

    with pytest.raises(RuntimeError, match="half-way"):
        fail()
    assert [c.subject for c in changes] == ["box"]


@pytest.mark.parametrize(
    "use",
    [
        lambda g: g.add("ball", "object"),
        lambda g: g.set("box", radius=0.5),
        lambda g: g.remove("box"),
        lambda g: g.relate("R2", "near", "box"),
        lambda g: g.unrelate("R2", "pursues", "home"),
        lambda g: g.attributes("box"),
        lambda g: g.nodes(),
        lambda g: g.edge("R2", "pursues", "home"),
        lambda g: g.stamp("box"),
    ],
)
def test_whoever_needs_a_whole_graph_waits_while_another_thread_holds_it(
    graph: KnowledgeGraph, use: Callable[[KnowledgeGraph], object]
) -> None:
    graph.relate("R2", "pursues", "home")
    started, done = threading.Event(), threading.Event()

    def body() -> None:
        started.set()
        use(graph)
        done.set()

    other = threading.Thread(target=body)
    with graph.locked() as view:
        before = {n: dict(view.nodes[n]) for n in view}, list(view.edges), graph.revision
        other.start()
        assert started.wait(10.0)
        assert not done.wait(0.03)
        assert before == ({n: dict(view.nodes[n]) for n in view}, list(view.edges), graph.revision)
    other.join(timeout=10.0)
    assert done.is_set()


def test_a_kind_stands_for_those_that_extend_it(graph: KnowledgeGraph) -> None:
    heard: list[KnowledgeChanged] = []
    graph.subscribe(heard.append, kind="object")
    graph.add("anna", "person", role="nurse")
    graph.add("dock", "place", pose=Pose2(0.0, 0.0))
    graph.relate("anna", "at", "dock")
    assert [(change.what, change.subject) for change in heard] == [
        ("node added", "anna"),
        ("attribute", "anna"),
        ("edge added", "anna"),
    ]
