"""Queries as people write them: what they find, what they give, and what they say where they are wrong."""

from __future__ import annotations

import math
import threading

import pytest

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError, KnowledgeError
from rocs_bt.base.geometry import Pose2
from rocs_bt.base.signal import Signal
from rocs_bt.base.units import ANGLE, LENGTH, Quantity
from rocs_bt.event import NullSink
from rocs_bt.knowledge import (
    SCHEMA,
    Attribute,
    Knowledge,
    KnowledgeGraph,
    NodeKind,
    QueryContext,
    compile_query,
    find,
)


@pytest.fixture
def yard() -> Knowledge:
    """A robot at (0, 0) that faces north, four places in a row, what stands around, and who is after what."""
    made = Knowledge("R2", SimulatedClock(0.05), NullSink())
    made.signals.declare(Signal("pose", 3, (LENGTH, LENGTH, ANGLE), max_age=1.0))
    made.signals.declare(Signal("front", 3, (LENGTH,), max_age=1.0))
    made.signals.declare(Signal("stop_distance", 1, (LENGTH,), max_age=1.0))
    made.signals.freeze()
    made.signals.update({"pose": (0.0, 0.0, math.pi / 2), "front": (0.4, 2.0, 3.0), "stop_distance": (0.5,)}, 0.0)
    graph = made.graph
    for i in range(4):
        graph.add(f"box{i}", "object", pose=Pose2(float(i), 0.0), moves=i % 2 == 0)
    graph.add("felt", "object", distance=0.3)
    graph.add("anna", "person", pose=Pose2(0.0, 2.0), role="nurse")
    for name, x in zip("abcd", (0.0, 1.0, 2.0, 3.0), strict=True):
        graph.add(name, "place", pose=Pose2(x, 5.0), tolerance=0.1 * (x + 1.0))
    for source, target, length in (("a", "b", 1.0), ("b", "c", 2.0), ("c", "d", 3.0), ("b", "a", 1.0)):
        graph.relate(source, "connects", target, length=length)
    graph.add("home", "goal", pose=Pose2(9.0, 9.0))
    graph.add("away", "goal", pose=Pose2(19.0, 9.0))
    graph.relate("R2", "pursues", "home")
    graph.relate("R2", "at", "a")
    return made


FOUND = [
    ("object where moves", ["box0", "box2"]),
    ("object where distance(pose, robot) < 1.5 m", ["box0", "box1"]),
    ("object where distance(object) < 150 cm", ["box0", "box1"]),
    ('person where role == "nurse"', ["anna"]),
    ('person where role != "nurse"', []),
    ("object where abs(bearing(object)) < 10 deg and distance(object) > 1 m", ["anna"]),
    ("object where bearing(object) == -90 deg", ["box0", "box1", "box2", "box3"]),
    ("object where distance < stop_distance", ["felt"]),
    ("place a where a.pose.x > 1.5 m", ["c", "d"]),
    ('place where distance(place, "home") < 7.5 m', ["d"]),
    ("goal, no robot pursues goal", ["away"]),
    ('robot pursues "home"', ["R2"]),
    ('robot pursues "away"', []),
    ('"R2" at place', ["a"]),
    ("thing where age(thing) == 0 s and thing.t == now limit 2", ["R2", "a"]),
    ("object changed since 13", ["anna", "felt"]),
    ("place where sqrt(tolerance * tolerance) > 0.35 m", ["d"]),
    ("object where (distance if known(distance) else 9 m) < 1 m", ["felt"]),
]


@pytest.mark.parametrize(("text", "names"), FOUND, ids=[text for text, _ in FOUND])
def test_what_a_query_finds(yard: Knowledge, text: str, names: list[str]) -> None:
    found = yard.ask(text)
    assert found.names == names
    assert yard.holds(text) == bool(found) == bool(names)


ROWS = [
    ("place a connects(road) place b where road.length > 1.5 m", "bc cd"),
    ("place a connects place b where connects.length * 2 > 5 m", "cd"),
    ("place a connects place b order by connects.length descending limit 1", "cd"),
    ("robot at place connects+ place last, no last connects place", "Raa Rac Rad"),
]


@pytest.mark.parametrize(("text", "rows"), ROWS, ids=[text for text, _ in ROWS])
def test_which_pairs_a_pattern_finds(yard: Knowledge, text: str, rows: str) -> None:
    assert ["".join(row).replace("R2", "R") for row in yard.ask(text).rows] == rows.split()


def test_a_query_without_a_pattern_asks_whether(yard: Knowledge) -> None:
    assert yard.holds("where min(front) < stop_distance and front[1] > 1 m and max(front[1:]) == 3 m")
    assert not yard.holds('where distance("home") < 1 m')
    assert yard.ask("where min(front) < 1 m").rows == ((),)
    assert yard.ask('"home"').rows == ((),)
    assert not yard.ask('"nowhere"')


def test_what_it_gives(yard: Knowledge) -> None:
    found = yard.ask("object order by distance(object) limit 2 give distance(object) * 2, moves, pose, distance, kind")
    assert found.columns == ("distance(object) * 2", "moves", "pose", "distance", "kind")
    assert found.values == (
        (0.0, True, Pose2(0.0, 0.0), None, "object"),
        (2.0, False, Pose2(1.0, 0.0), None, "object"),
    )
    assert found.dicts[1]["object"] == "box1"
    assert found.dicts[1]["moves"] is False
    assert found.first == "box0"
    assert yard.ask("robot pursues goal give goal.pose, goal, robot.pose").values == (
        (Pose2(9.0, 9.0), "home", Pose2(0.0, 0.0, math.pi / 2)),
    )


def test_parameters(yard: Knowledge) -> None:
    assert yard.ask("object where distance(pose, here) < 1.5 m", here=Pose2(3.0, 0.0)).names == ["box2", "box3"]
    assert yard.ask(
        "object where distance(pose, way) < reach", way=[(1.0, 1.0), (1.0, -1.0)], reach=Quantity(0.1, LENGTH)
    ).names == ["box1"]
    assert yard.ask("object where object == which", which="box2").names == ["box2"]
    assert yard.ask("object where moves and flag", flag=False).names == []
    assert yard.ask("object where distance(object, spot) < 1 m", spot="box3").names == ["box3"]
    assert yard.ask("place where tolerance > 0.05 m * factor", factor=7).names == ["d"]
    assert yard.ask("object changed since mark", mark=yard.revision).names == []
    with pytest.raises(KnowledgeError, match="the parameter 'way' must be a number, a Quantity"):
        yard.ask("object where distance(pose, way) < 1 m", way=[])
    query = compile_query("object")
    with pytest.raises(KnowledgeError, match="needs the parameters none; found way"):
        query.ask(yard.graph, way=1.0)


def test_a_new_time_and_new_writes_are_seen_by_a_compiled_query(yard: Knowledge) -> None:
    near = "object order by distance(object) limit 1"
    assert yard.ask(near).first == "box0"
    yard.graph.remove("box0")
    yard.graph.set("anna", pose=Pose2(0.0, 0.5))
    assert yard.ask(near).first == "anna"
    yard.signals.write("pose", (3.0, 0.0, 0.0), 0.0)
    assert yard.ask(near).first == "box3"


def test_where_a_robot_is_not_known_nothing_is_near(yard: Knowledge) -> None:
    yard.signals.write("pose", (math.nan,) * 3, 0.0)
    assert not yard.holds("object where distance(object) < 100 m")
    assert yard.ask("object order by distance(object) limit 2").names == ["anna", "box0"], "by name"
    yard.graph.set("R2", pose=Pose2(2.0, 0.0))  # what the graph knows serves then
    assert yard.ask("object order by distance(object) limit 2").names == ["box2", "box1"]


def test_as_of_a_time(yard: Knowledge) -> None:
    clock = yard.clock
    assert isinstance(clock, SimulatedClock)
    clock.advance(40)
    yard.graph.remove("box0")
    yard.graph.set("box1", pose=Pose2(50.0, 0.0))
    assert yard.ask("object where moves").names == ["box2"]
    assert yard.ask("object where moves as of 1 s").names == ["box0", "box2"]
    assert yard.ask('object where distance(object, "box0") < 1.5 m as of 1 s ago').names == ["box0", "box1"]
    assert yard.ask("object where moves as of when", when=Quantity(1.0, LENGTH / LENGTH)).names == ["box0", "box2"]
    assert not yard.ask("object where distance(object, robot) < 9 m as of 1 s"), "nobody knows where it was then"
    with pytest.raises(KnowledgeError, match=r"no history of the graph is given, so its state at 1 s"):
        yard.query("object as of 1 s").ask(yard.graph)


TOO_LARGE = [
    ("object " + "where moves and " * 90 + "moves", "at most 1000 characters"),
    ("object where " + "(" * 60 + "moves" + ")" * 60, "at most 40 deep"),
]


@pytest.mark.parametrize(("text", "message"), TOO_LARGE)
def test_a_query_that_is_too_large_is_refused(text: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        compile_query(text)


def test_a_fault_on_a_later_line_is_told_there() -> None:
    with pytest.raises(InputError) as caught:
        compile_query("object\nwhere moves\n  and mvoes")
    assert [(f.line, f.column) for f in caught.value.faults] == [(3, 7)]


def test_knowledge_tells_the_place_too(yard: Knowledge) -> None:
    with pytest.raises(InputError, match=r"^query:1:14: 'mvoes': nothing is named"):
        yard.ask("object where mvoes")


def test_find_says_the_same_as_the_text(yard: Knowledge) -> None:
    assert str(find("object").where("moves").within("2 m").nearest(3)) == (
        "object where moves and distance(object, robot) < 2 m order by distance(object, robot) limit 3"
    )
    road = find("place", "a").link("connects", "place", "b").where("b.tolerance > 0.25 m or a == b").where("a != b")
    text = "place a connects place b where (b.tolerance > 0.25 m or a == b) and a != b give connects.length"
    assert str(road.give("connects.length")) == text
    assert yard.ask(road.give("connects.length")) == yard.ask(text)
    assert str(find("goal").without("peer pursues goal").also("robot at place").as_of("5 s ago").changed_since(3)) == (
        "goal, no peer pursues goal, robot at place as of 5 s ago changed since 3"
    )
    assert str(find("object").order_by("radius", descending=True)) == "object order by radius descending"
    assert yard.ask(find("object").nearest(2, to='"box3"')).names == ["box3", "box2"]


def test_a_kind_of_the_projects_own_is_asked_for_like_any_other() -> None:
    schema = SCHEMA.extended([NodeKind("cone", {"colour": Attribute(str), "class": Attribute(int)}, extends="object")])
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2", schema)
    graph.add("c", "cone", colour="red", pose=Pose2(1.0, 0.0))
    graph.set("c", **{"class": 10**400})
    query = compile_query("object o where o.kind == 'cone'", schema)
    assert query.ask(graph).names == ["c"]
    assert compile_query("cone where colour == 'red' and distance(cone) < 2 m", schema).ask(
        graph, QueryContext("R2", Pose2(0.0, 0.0))
    ).names == ["c"]
    with pytest.raises(KnowledgeError, match="compiled for another schema"):
        compile_query("object").ask(graph)


def test_a_query_sees_one_moment_while_others_write(yard: Knowledge) -> None:
    graph, going = yard.graph, threading.Event()
    graph.add("left", "object", pose=Pose2(5.0, 5.0))

    def swap() -> None:
        while not going.is_set():
            for x in (-5.0, 5.0):
                with graph.locked():  # to nobody else are the two ever on one side, or one of them gone
                    graph.set("left", pose=Pose2(x, 5.0))
                    graph.remove("box3")
                    graph.add("box3", "object", pose=Pose2(-x, 5.0))

    graph.set("box3", pose=Pose2(-5.0, 5.0))
    writer = threading.Thread(target=swap)
    writer.start()
    try:
        for _ in range(300):
            assert len(yard.ask("object where pose.y == 5 m and pose.x > 0 m")) == 1
            assert len(yard.ask("object where distance(pose, spot) < 1 m", spot=Pose2(5.0, 5.0))) == 1
            assert len(yard.ask("object order by distance(pose, spot) limit 2", spot=Pose2(0.0, 5.0))) == 2
    finally:
        going.set()
        writer.join()
