"""The query engine against the naive interpreter, on graphs that were written to in whatever order."""

from __future__ import annotations

import math
import random
import re
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import InputError, KnowledgeError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import NullSink
from rocs_bt.expression import FUNCTIONS
from rocs_bt.knowledge import SCHEMA, KnowledgeGraph, QueryContext, Readable, compile_query
from rocs_bt.knowledge.history import GraphState
from rocs_bt.knowledge.query import read_parameters

from .naive_query import Asked, Atom, Hop, Junction, Var, answers, beside

KINDS = ("object", "object", "person", "peer", "place", "place", "goal")
PLACED = ("thing", "body", "robot", "object", "person", "peer", "place", "goal")
NUMBERS = {"object": "distance", "peer": "spread", "place": "tolerance", "goal": "tolerance", "person": "radius"}
HOPS = {"near": ("thing", "thing"), "connects": ("place", "place"), "at": ("body", "place"), "sees": ("peer", "body")}
NAMES = [f"n{i}" for i in range(9)]

poses = st.builds(Pose2, st.integers(-3, 3).map(float), st.integers(-3, 3).map(float), st.just(0.0))


def graph_of(seed: int) -> KnowledgeGraph:
    """A graph after a history of writes, some of them taken back: drawn evenly, so that most queries find something."""
    rng = random.Random(seed)
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")
    graph.add("R2", "robot", pose=rng.choice([None, pose_of(rng)]))
    for name in NAMES:
        add(graph, name, rng)
    for _ in range(rng.randrange(8)):
        name = rng.choice(NAMES)
        if rng.random() < 0.3:
            graph.remove(name)
            add(graph, name, rng)
        else:
            graph.set(name, pose=pose_of(rng))
    for relation, ends in HOPS.items():
        sources, targets = (graph.nodes(kind) for kind in ends)
        for _ in range(rng.randrange(8) if sources and targets else 0):
            edge = rng.choice(sources), relation, rng.choice(targets)
            graph.relate(*edge)
            if rng.random() < 0.2:
                graph.unrelate(*edge)
    return graph


def pose_of(rng: random.Random) -> Pose2:
    return Pose2(float(rng.randint(-3, 3)), float(rng.randint(-3, 3)))


def add(graph: KnowledgeGraph, name: str, rng: random.Random) -> None:
    kind = rng.choice(KINDS)
    pose = None if kind not in ("place", "goal") and rng.random() < 0.2 else pose_of(rng)
    graph.add(name, kind, pose=pose, **{NUMBERS[kind]: rng.choice([None, 0.0, 0.5, 1.0])})
    if kind in ("object", "person"):
        graph.set(name, moves=rng.choice([None, True, False]))


graphs = st.integers(0, 10**9).map(graph_of)


@st.composite
def queries(draw: st.DrawFn) -> Asked:
    shown: list[Var] = []

    def var(kind: str) -> Var:
        kinds = sorted(SCHEMA.families[kind] & set(PLACED))
        chosen = draw(st.sampled_from([kind, kind, *kinds]))
        same = [old for old in shown if old.kind == chosen]
        if same and draw(st.booleans()):
            return draw(st.sampled_from(same))
        taken = {old.name for old in shown}
        new = Var(chosen if chosen not in taken and draw(st.booleans()) else f"v{len(shown)}", chosen)
        shown.append(new)
        return new

    alone = [var("thing") for _ in range(draw(st.sampled_from([0, 0, 0, 1])))]
    hops = []
    for _ in range(draw(st.sampled_from([0, 1, 1, 2] if alone else [1, 1, 2]))):
        relation = draw(st.sampled_from(sorted(HOPS)))
        source, target = var(HOPS[relation][0]), var(HOPS[relation][1])
        sign = draw(st.sampled_from(["", "", "+", "*"])) if HOPS[relation][0] == HOPS[relation][1] else ""
        hops.append(Hop(source, relation, target, sign))
    absent = []
    for _ in range(draw(st.sampled_from([0, 0, 1, 2, 3]))):  # the hidden names of one clause mean nothing in another
        relation = draw(st.sampled_from(sorted(HOPS)))
        ends = [Var(f"h{i}", kind) for i, kind in enumerate(HOPS[relation])]
        for i, kind in enumerate(HOPS[relation]):
            fitting = [old for old in shown if SCHEMA.is_a(old.kind, kind)]
            if fitting and draw(st.booleans()):
                ends[i] = draw(st.sampled_from(fitting))
        absent.append(Hop(ends[0], relation, ends[1]))
    return Asked(
        tuple(hops),
        tuple(alone),
        tuple(absent),
        draw(st.none() | atoms(shown) | conditions(shown)),
        draw(st.none() | st.tuples(measures(shown), st.booleans())),
        draw(st.none() | st.integers(1, 4)),
        draw(st.none() | st.none() | st.integers(0, 30)),
        tuple(shown),
    )


@st.composite
def measures(draw: st.DrawFn, shown: list[Var]) -> Atom:
    var = draw(st.sampled_from(shown))
    if var.kind in NUMBERS and draw(st.booleans()):
        name = NUMBERS[var.kind]
        return Atom(f"{var.name}.{name}", "attribute", (var.name, name))
    others = ["robot", *NAMES[:2], *(old.name for old in shown)]
    other = draw(st.sampled_from(others))
    text = f'"{other}"' if other in NAMES else other
    ends = [var.name, text]
    if other not in ("robot", *NAMES) and draw(st.booleans()):
        ends = [f"{end}.pose" for end in ends]
    return Atom(f"distance({', '.join(draw(st.permutations(ends)))})", "distance", (var.name, other))


@st.composite
def atoms(draw: st.DrawFn, shown: list[Var]) -> Atom:
    var = draw(st.sampled_from(shown))
    form = draw(st.sampled_from(["less", "less", "truth", "same", "kind", "known"]))
    if form == "truth" and var.kind in ("object", "person"):
        text = "moves" if var == shown[0] and draw(st.booleans()) else f"{var.name}.moves"
        return Atom(text, "attribute", (var.name, "moves"))
    if form == "same":
        other = draw(st.sampled_from([*NAMES[:3], *(old.name for old in shown)]))
        text = f"'{other}'" if other in NAMES else other
        return Atom(" == ".join(draw(st.permutations([var.name, text]))), "same", (var.name, other))
    if form == "kind":
        kind = draw(st.sampled_from(KINDS))
        return Atom(f'{var.name}.kind == "{kind}"', "kind", (var.name, kind))
    if form == "known":
        return Atom(f"known({var.name}.pose)", "known", (var.name, "pose"))
    left = draw(measures(shown))
    bound = draw(st.sampled_from([0.75, 1.5, 2.5, 4.0, 6.0]))
    text = f"{left} < {bound} m" if draw(st.booleans()) else f"{bound} m > {left}"
    return Atom(text, "less", (left, bound))


def conditions(shown: list[Var]) -> st.SearchStrategy[Any]:
    def joined(inner: Any) -> Any:
        several = st.tuples(st.sampled_from(["and", "and", "or"]), st.lists(inner, min_size=2, max_size=3).map(tuple))
        negated = st.tuples(st.just("not"), st.tuples(inner))
        return (several | negated).map(lambda made: Junction(*made))

    return st.recursive(atoms(shown), joined, max_leaves=4)


def asked_of(graph: Readable, asked: Asked, here: Pose2 | None) -> list[tuple[str, ...]]:
    query = compile_query(str(asked))
    context = QueryContext("R2", here, 1.0)
    found = query.ask(graph, context)
    assert query.holds(graph, context) == bool(found)
    assert found.variables == tuple(var.name for var in asked.shown)
    return list(found.rows)


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(graph=graphs, asked=queries(), here=st.none() | poses)
def test_the_engine_answers_as_the_naive_interpreter(graph: KnowledgeGraph, asked: Asked, here: Pose2 | None) -> None:
    expected = answers(asked, graph, here)
    assert asked_of(graph, asked, here) == expected, str(asked)
    assert asked_of(GraphState.of(graph), asked, here) == expected, "of a graph that has no index"


@pytest.mark.soak
@settings(max_examples=5_000, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
@given(graph=graphs, asked=queries(), here=st.none() | poses)
def test_the_engine_answers_as_the_naive_interpreter_at_length(
    graph: KnowledgeGraph, asked: Asked, here: Pose2 | None
) -> None:
    assert asked_of(graph, asked, here) == answers(asked, graph, here), str(asked)


@st.composite
def nearest(draw: st.DrawFn) -> Asked:
    """Queries that the index answers: near one place, or the nearest to one."""
    var = Var("it", draw(st.sampled_from(["thing", "object", "object", "person"])))
    other = draw(st.sampled_from(["robot", *NAMES]))
    text = "distance(it)" if other == "robot" else f'distance(it, "{other}")'
    measure = Atom(text, "distance", ("it", other))
    bound = draw(st.sampled_from([0.5, 1.5, 3.0, 6.0]))
    within = Atom(f"{text} < {bound} m", "less", (measure, bound))
    where = draw(st.none() | st.just(within) | atoms([var]))
    if where is not None and draw(st.booleans()):
        where = Junction("and", (within, where))
    order = draw(st.sampled_from([(measure, False), (measure, False), (measure, True), None]))
    return Asked((), (var,), (), where, order, draw(st.none() | st.integers(1, 9)), None, (var,))


@settings(max_examples=100, deadline=None)
@given(graph=graphs, asked=nearest(), here=st.none() | poses)
def test_the_nearest_are_the_naive_interpreters(graph: KnowledgeGraph, asked: Asked, here: Pose2 | None) -> None:
    assert asked_of(graph, asked, here) == answers(asked, graph, here), str(asked)


@settings(max_examples=60, deadline=None)
@given(
    graph=graphs,
    path=st.lists(st.tuples(st.integers(-4, 4), st.integers(-4, 4)), min_size=1, max_size=4),
    reach=st.sampled_from([0.4, 1.1, 2.3]),
)
def test_what_is_along_a_path(graph: KnowledgeGraph, path: list[tuple[int, int]], reach: float) -> None:
    types, _ = read_parameters({"path": path})
    query = compile_query(f"thing where distance(pose, path) < {reach} m", parameters=types)
    found = set(query.ask(graph, path=path).names)
    for name in graph.nodes("thing"):
        pose = graph.get(name, "pose")
        distance = math.inf if pose is None else beside(pose, [(float(x), float(y)) for x, y in path])
        if abs(distance - reach) > 0.05:
            assert (name in found) == (distance < reach)


@settings(max_examples=100, deadline=None)
@given(graph=graphs, since=st.integers(0, 60), kind=st.sampled_from([None, "thing", "object"]))
def test_what_changed_since_a_revision_is_told_newest_first(
    graph: KnowledgeGraph, since: int, kind: str | None
) -> None:
    rows = {name: graph.row(name) or {} for name in graph.nodes(kind)}
    newer = [name for name in rows if rows[name]["revision"] > since]
    expected = sorted(newer, key=lambda name: -rows[name]["revision"])
    assert graph.changed_since(since, kind) == expected
    assert Readable.changed_since(graph, since, kind) == expected


def words(text: str) -> list[str]:
    return text.split()


WORDS = st.sampled_from(
    words("object place goal robot peer thing a b pursues connects near no , where order by limit give as of changed")
    + words("since ( ) [ ] . + - * / < > == != 'x' 1 2.5 m s deg moves pose pose.x tolerance distance bearing age")
    + words("known and or not if else True inf descending min ago 0 # $ ? ; ' \\")
    + ['"home"', '"']
)


@settings(max_examples=150, deadline=None)
@given(st.lists(WORDS, max_size=14).map(" ".join) | st.text(max_size=60))
def test_a_text_is_a_query_or_is_refused_with_its_place(text: str) -> None:
    try:
        query = compile_query(text)
    except InputError as error:
        for fault in error.faults:
            assert fault.message
            assert 0 <= fault.column <= len(text) + 1
        return
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")
    graph.add("home", "goal", pose=Pose2(1.0, 2.0))
    try:
        query.ask(graph, QueryContext("R2", Pose2(0.0, 0.0), 1.0))
    except KnowledgeError as error:
        assert "no history of the graph" in str(error)


@pytest.mark.parametrize(
    "function",
    sorted(name for name, f in FUNCTIONS.items() if f.usage.startswith(f"{name}(group")),
)
def test_functions_of_groups_are_refused_for_one_value_of_a_row(function: str) -> None:
    truth = FUNCTIONS[function].usage.startswith(("any", "all", "count"))
    more = {"dot": ", [2]", "min_valid": ", 1"}.get(function, "")
    call = f"{function}({'object.moves' if truth else 'object.radius'}{more})"
    test = {"any": "", "all": "", "count": " == 1", "argmin": " == 0"}.get(function, " < 1 m")
    for text in (f"object give {call}", f"object where known(pose) and {call}{test}"):
        with pytest.raises(InputError, match=re.escape(f"'{call}' is of one value")) as caught:
            compile_query(text)
        assert caught.value.faults[0].column > 1


def test_functions_of_groups_take_lists() -> None:
    compile_query("object where max(covariance) < 1 m2 and max(radius, length) < 1 m give sum(covariance)")


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("place x, no x connects place y, no place y connects x", ["e"]),
        ('place x, no x connects "nowhere", no x connects "b"', ["b", "c", "d", "e"]),
        ('place x, no "a" connects x, no x connects "b"', ["c", "d", "e"]),
        ("place x, no x connects place y connects place z, no place z connects place y connects x", ["c", "d", "e"]),
    ],
)
def test_each_no_clause_has_its_own_scope(text: str, names: list[str]) -> None:
    graph = KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")
    for name in "abcde":
        graph.add(name, "place", pose=Pose2(0.0, 0.0))
    for source, target in ("ab", "ba", "cd"):
        graph.relate(source, "connects", target)
    assert list(compile_query(text).ask(graph, QueryContext("R2", None, 1.0)).names) == names
