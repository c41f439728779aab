from __future__ import annotations

import copy
import math

import networkx as nx
import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import KnowledgeError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import KnowledgeChanged, ListSink, pack
from rocs_bt.knowledge import Knowledge, KnowledgeGraph, Stamp

HERE, THERE = Pose2(0.0, 0.0), Pose2(3.0, 4.0, 1.0)


@pytest.fixture
def graph(clock: SimulatedClock, sink: ListSink) -> KnowledgeGraph:
    made = KnowledgeGraph(clock, sink, "R2")
    made.add("R2", "robot")
    made.add("home", "goal", pose=HERE)
    made.add("box", "object", pose=THERE, radius=0.25)
    sink.events.clear()
    return made


def told(sink: ListSink) -> list[tuple[str, str, str, object]]:
    return [(e.what, e.subject, e.name, e.value) for e in sink.events if isinstance(e, KnowledgeChanged)]


def test_everything_written_has_a_time_and_a_revision(graph: KnowledgeGraph, clock: SimulatedClock) -> None:
    first = graph.revision
    clock.advance(2)
    graph.set("box", height=0.4)
    clock.advance(1)
    graph.set("box", radius=0.3)
    assert graph.stamp("box", "height") == Stamp(0.1, first + 1)
    assert graph.stamp("box", "radius") == Stamp(3 * 0.05, first + 2)
    assert graph.stamp("box") == graph.stamp("box", "radius")
    assert graph.stamp("box", "length") == Stamp(-math.inf, 0)
    graph.relate("R2", "near", "box", distance=1.0)
    assert graph.view.edges["R2", "box", "near"]["revision"] == graph.revision == first + 3
    assert graph.view.edges["R2", "box", "near"]["t"] == 3 * 0.05


def test_an_equal_value_renews_the_time_and_is_no_change(
    graph: KnowledgeGraph, clock: SimulatedClock, sink: ListSink
) -> None:
    graph.relate("R2", "near", "box", distance=1.0)
    before, node, revision = graph.stamp("box", "radius"), graph.stamp("box"), graph.revision
    sink.events.clear()
    clock.advance()
    graph.set("box", radius=0.25)
    graph.relate("R2", "near", "box", distance=1.0)
    assert graph.stamp("box", "radius") == Stamp(0.05, before.revision)
    assert graph.stamp("box") == Stamp(0.05, node.revision)
    assert graph.view.edges["R2", "box", "near"]["t"] == 0.05
    assert graph.view.edges["R2", "box", "near"]["revision"] == revision == graph.revision
    assert sink.events == []


def test_each_change_is_an_event_with_the_next_revision(graph: KnowledgeGraph, sink: ListSink) -> None:
    first = graph.revision
    graph.add("spot", "place", pose=THERE, tolerance=0.5)
    graph.set("spot", tolerance=0.6)
    graph.relate("R2", "near", "box", distance=1.0)
    graph.relate("R2", "near", "box", distance=2.0)
    graph.relate("R2", "pursues", "home")
    graph.remove("box")
    assert told(sink) == [
        ("node added", "spot", "place", None),
        ("attribute", "spot", "pose", [3.0, 4.0, 1.0]),
        ("attribute", "spot", "tolerance", 0.5),
        ("attribute", "spot", "tolerance", 0.6),
        ("edge added", "R2", "near", "box"),
        ("edge changed", "R2", "near", "box"),
        ("edge added", "R2", "pursues", "home"),
        ("edge removed", "R2", "near", "box"),
        ("node removed", "box", "object", None),
    ]
    assert [e.revision for e in sink.events] == list(range(first + 1, first + 10))
    assert [e.attributes["distance"] for e in sink.events if "edge" in e.what and e.attributes] == [1.0, 2.0]
    assert {e.agent for e in sink.events} == {"R2"}


@pytest.mark.parametrize(
    ("write", "message"),
    [
        (lambda g: g.add("x", "sensr"), r"no kind named 'sensr'. Did you mean 'sensor'\?"),
        (lambda g: g.add("box", "goal", pose=HERE), "'box' exists already, of kind object; change it"),
        (lambda g: g.add("", "goal", pose=HERE), "a node's name has 1 to 200 printable characters, found ''"),
        (lambda g: g.add(3, "goal", pose=HERE), "a node's name has 1 to 200 printable characters, found 3"),
        (lambda g: g.add("\x1b[2J", "goal", pose=HERE), r"printable characters, found '\\x1b\[2J'"),
        (lambda g: g.add("a\nb", "goal", pose=HERE), r"printable characters, found 'a\\nb'"),
        (lambda g: g.add("x" * 201, "goal", pose=HERE), "1 to 200 printable characters, found 'xxx"),
        (lambda g: g.add("x", "goal"), "goal 'x' needs pose"),
        (lambda g: g.add("x", "goal", pose=HERE, tolerence=1.0), "has no attribute 'tolerence'. Did you mean 'toler"),
        (lambda g: g.set("bx", radius=1.0), r"no node named 'bx'. Did you mean 'box'\? Knowledge has: R2, box, home"),
        (
            lambda g: g.set("box", radius=0.5, height=math.nan),
            "attribute 'height' of 'object box' must be .* found nan",
        ),
        (lambda g: g.set("box", radius=0.5, weight=1.0), "'object box' has no attribute 'weight'.*It has: bearing"),
        (lambda g: g.set("home", pose=None), "attribute 'pose' of 'goal home' must be a Pose2"),
        (lambda g: g.relate("R2", "persues", "home"), r"no relation named 'persues'. Did you mean 'pursues'\?"),
        (lambda g: g.relate("R2", "pursues", "box"), "'pursues' cannot end at 'box' of kind object; .*: goal"),
        (
            lambda g: g.relate("box", "pursues", "home"),
            "cannot start from 'box' of kind object; .*: robot, peer",
        ),
        (lambda g: g.relate("R2", "near", "bx"), "no node named 'bx'"),
        (lambda g: g.relate("R2", "near", "box", distance=-1.0), "attribute 'distance' of 'R2 near box'"),
        (lambda g: g.relate("R2", "near", "box", far=1.0), "'R2 near box' has no attribute 'far'. .*distance"),
        (lambda g: g.unrelate("R2", "near", "box"), "no edge R2 -near-> box; it leads to nothing"),
        (lambda g: g.remove("bx"), "no node named 'bx'"),
        (lambda g: g.subscribe(print, kind="gaol"), "Did you mean 'goal'"),
        (lambda g: g.subscribe(print, relation="nearr"), "Did you mean 'near'"),
        (lambda g: g.get("box", "radios"), r"no attribute of the object 'box' named 'radios'. Did you mean 'radius'\?"),
        (lambda g: g.get("bx", "radius"), "no node named 'bx'"),
        (lambda g: g.attributes("bx"), "no node named 'bx'"),
        (lambda g: g.nodes("gaol"), "no kind named 'gaol'"),
        (lambda g: g.related("bx", "near"), "no node named 'bx'"),
        (lambda g: g.related("box", "nearr"), "no relation named 'nearr'"),
        (lambda g: g.edge("box", "near", "bx"), "no node named 'bx'"),
        (lambda g: g.stamp("box", "radios"), "Did you mean 'radius'"),
    ],
)
def test_what_the_schema_refuses_leaves_everything_as_it_was(
    graph: KnowledgeGraph, sink: ListSink, write: object, message: str
) -> None:
    before = {n: dict(graph.view.nodes[n]) for n in graph.view}, list(graph.view.edges), graph.revision
    with pytest.raises(KnowledgeError, match=message):
        write(graph)
    assert before == ({n: dict(graph.view.nodes[n]) for n in graph.view}, list(graph.view.edges), graph.revision)
    assert sink.events == []


@pytest.mark.parametrize(
    "write",
    [
        lambda v: v.nodes["box"].update(radius=1.0),
        lambda v: v.nodes["box"].__setitem__("radius", 1.0),
        lambda v: v.nodes["box"].pop("radius"),
        lambda v: v.nodes["box"].clear(),
        lambda v: v.edges["R2", "box", "near"].__setitem__("distance", 1.0),
        lambda v: v["R2"]["box"]["near"].setdefault("distance", 1.0),
        lambda v: v.add_node("x"),
        lambda v: v.remove_node("box"),
        lambda v: v.add_edge("R2", "home"),
        lambda v: v.remove_edge("R2", "box"),
    ],
)
def test_the_view_cannot_be_written(graph: KnowledgeGraph, write: object) -> None:
    graph.relate("R2", "near", "box", distance=2.0)
    with pytest.raises((KnowledgeError, nx.NetworkXError)):
        write(graph.view)
    assert graph.get("box", "radius") == 0.25
    assert graph.edge("R2", "near", "box") == {"distance": 2.0}


def test_the_view_is_live_and_serves_networkx(graph: KnowledgeGraph) -> None:
    view = graph.view
    for name, x in (("a", 1.0), ("b", 2.0), ("c", 3.0)):
        graph.add(name, "place", pose=Pose2(x, 0.0))
    graph.relate("a", "connects", "b", length=1.0)
    graph.relate("b", "connects", "c", length=1.0)
    graph.relate("a", "connects", "c", length=5.0)
    assert nx.dijkstra_path(view, "a", "c", weight="length") == ["a", "b", "c"]
    assert set(nx.descendants(view, "a")) == {"b", "c"}


@pytest.mark.parametrize("duplicate", [lambda v: v.copy(), copy.deepcopy, lambda v: v.to_undirected(), nx.MultiDiGraph])
def test_a_copy_of_the_view_is_an_ordinary_graph(graph: KnowledgeGraph, duplicate: object) -> None:
    graph.relate("R2", "near", "box", distance=2.0)
    mine = duplicate(graph.view)
    assert mine.edges["R2", "box", "near"]["distance"] == 2.0
    if not nx.is_frozen(mine):
        mine.nodes["box"]["mine"] = 1
        mine.add_edge("home", "box", "mine", length=1.0)
    assert "mine" not in graph.view.nodes["box"]
    assert not graph.view.has_edge("home", "box")


@pytest.mark.parametrize("when", ["before", "after"])
def test_a_sensor_node_shows_the_newest_values_of_its_signal(knowledge: Knowledge, when: str) -> None:
    if when == "after":
        knowledge.signals.freeze()
    knowledge.graph.add("sonar", "sensor", signal="front", rate=20.0)
    knowledge.signals.write("front", [1.0, math.inf, 3.0], 0.0)
    live = knowledge.graph.get("sonar", "values")
    assert live.tolist() == [1.0, math.inf, 3.0]
    knowledge.signals.write("front", [-1.0, 2.0, 2.0], 0.05)
    assert pack(knowledge.graph.get("sonar", "values")) == pack([math.nan, 2.0, 2.0])
    assert knowledge.graph.get("sonar", "values") is live
    with pytest.raises(ValueError, match="read-only"):
        live[0] = 0.0


def test_a_sensor_that_turns_to_another_signal_shows_that_one(knowledge: Knowledge) -> None:
    knowledge.graph.add("odometry", "sensor", signal="speed")
    knowledge.signals.update({"speed": 0.5, "wheel_speeds": [0.4, 0.6]}, 0.0)
    knowledge.graph.set("odometry", signal="wheel_speeds")
    assert knowledge.graph.get("odometry", "values").tolist() == [0.4, 0.6]
    knowledge.graph.set("odometry", signal=None)
    assert knowledge.graph.get("odometry", "values") is None


@pytest.mark.parametrize("frozen", [True, False])
def test_a_sensor_of_an_unknown_signal_is_refused(knowledge: Knowledge, frozen: bool) -> None:
    if frozen:
        knowledge.signals.freeze()

    def wire() -> None:
        knowledge.graph.add("sonar", "sensor", signal="frnt")
        knowledge.signals.freeze()

    with pytest.raises(KnowledgeError, match=r"'frnt'. Did you mean 'front'"):
        wire()
    assert knowledge.graph.has("sonar") is not frozen
