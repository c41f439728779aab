"""Cost of queries over 10,000 objects and 30,000 edges, relative to raw networkx and rdflib (SPARQL), in CPU time.

Run it with `python benchmarks queries`. rdflib is in the extra `bench`; without it its rows are skipped.
"""

from __future__ import annotations

import functools
import importlib.util
import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

import knowledge_world as world
from bench_knowledge import micros
from row import Row, size

NEAREST_BUDGET = 20.0  # [us]
PATIENCE = size(1e5, 1e2)  # [us] CPU time of a round


def run() -> Iterator[Row]:
    """All rows."""
    known, raw = world.known(), world.raw()
    rdf = world.Rdf() if importlib.util.find_spec("rdflib") else None
    for question in _questions(known, raw, rdf):
        yield from _beside(*question)
    yield from _past(known, raw, rdf)


def _questions(known: Any, raw: Any, rdf: world.Rdf | None) -> Iterator[tuple[str, Any, Any, Any, float | None]]:
    """Name; functions of ours, networkx and rdflib; budget [us]."""
    graph, radii = known.graph, itertools.cycle((0.25, 0.75))
    x, y = world.HERE

    def write_raw() -> None:
        raw.nodes["o1"]["radius"] = next(radii)

    def ask(text: str, **parameters: Any) -> Callable[[], Any]:
        return lambda: known.ask(text, **parameters)

    def theirs(question: str, **bound: str) -> Callable[[], Any] | None:
        return None if rdf is None else lambda: rdf.ask(question, **bound)

    def hop_raw(name: str) -> list[str]:
        return [target for _, target, key in raw.out_edges(name, keys=True) if key == "near"]

    def within_raw() -> list[str]:
        poses = raw.nodes(data="pose")
        return [name for name, pose in poses if math.hypot(pose.x - x, pose.y - y) < 2.0]

    def filter_raw() -> list[str]:
        return [name for name, row in raw.nodes(data=True) if row["moves"] and row["radius"] < 0.1]

    yield "read", lambda: graph.get("o1", "radius"), lambda: raw.nodes["o1"]["radius"], rdf and rdf.read, None
    yield (
        "write, checked",
        lambda: graph.set("o1", radius=next(radii)),
        write_raw,
        rdf and (lambda: rdf.write(next(radii))),
        None,
    )
    subscription = graph.subscribe(lambda change: None, node="o1")
    yield (
        "write, checked, with a subscription",
        lambda: graph.set("o1", radius=next(radii)),
        write_raw,
        rdf and (lambda: rdf.write(next(radii))),
        None,
    )
    subscription.close()
    nearest = theirs("nearest")
    yield "nearest, from Python", lambda: graph.nearest(x, y, "object"), lambda: world.nearest(raw), nearest, 20.0
    text = "object order by distance(pose, robot) limit 1"
    yield f"'{text}'", ask(text), lambda: world.nearest(raw), nearest, NEAREST_BUDGET
    yield (
        "'object where distance(pose, robot) < 2 m'",
        ask("object where distance(pose, robot) < 2 m"),
        within_raw,
        theirs("within"),
        None,
    )
    yield (
        "'object a near object where a == it'",
        ask("object a near object where a == it", it="o7"),
        lambda: hop_raw("o7"),
        theirs("hop", a="o7"),
        None,
    )
    yield (
        "two edges and an attribute",
        ask("object a near object b near object c where a == it and c.moves", it="o7"),
        lambda: [c for b in hop_raw("o7") for c in hop_raw(b) if raw.nodes[c]["moves"]],
        theirs("hops", a="o7"),
        None,
    )
    text = "object where moves and radius < 0.1 m"
    yield f"'{text}'", ask(text), filter_raw, theirs("filter"), None


def _beside(name: str, ours: Any, networkx: Any, rdflib: Any, budget: float | None) -> Iterator[Row]:
    value = _micros(ours)
    holds = None if budget is None else value <= budget
    words = "" if budget is None else f"<= {budget:g} us"
    yield Row(f"queries: {name}", value, "us", "networkx", value / _micros(networkx), words, holds)
    if rdflib is not None:
        yield Row(f"queries: {name}", value, "us", "rdflib", value / _micros(rdflib))


def _micros(call: Callable[[], object]) -> float:
    """CPU time of one call [us]; the number of calls is chosen to fill a round."""
    once = micros(call, 1, 1)
    return once if once > PATIENCE else micros(call, max(1, min(20_000, int(PATIENCE / max(once, 1.0)))), 3)


def _past(known: Any, raw: Any, rdf: world.Rdf | None) -> Iterator[Row]:
    """Queries of past states of 10,000 nodes, relative to a copy of the whole graph.

    networkx and rdflib have no history; the alternative is to copy the graph at every change and query the copy.
    """
    clock, graph = known.clock, known.graph
    for i in range(world.COUNT):
        graph.set(f"o{i}", radius=0.5 + i / 1e5)
        if i % (world.COUNT // 100) == 0:
            clock.advance()
    copies = [("networkx copied", _micros(raw.copy))]
    if rdf is not None:
        copies.append(("rdflib copied", _micros(rdf.copy)))
    t = clock.now() - 2.0
    yield from _of_copies("the whole graph as of a time", lambda: known.past.as_of(t), copies)
    for text, given in (
        ("object a near object b where a == it and b.moves as of 2 s ago", {"it": "o7"}),
        ("object b near object a where a == it as of 2 s ago", {"it": "o7"}),
        ("goal as of 2 s ago", {}),
        ("object order by distance(pose, robot) limit 1 as of 2 s ago", {}),
    ):
        yield from _of_copies(f"'{text}'", functools.partial(known.ask, text, **given), copies)


def _of_copies(name: str, ours: Callable[[], Any], copies: list[tuple[str, float]]) -> Iterator[Row]:
    value = _micros(ours)
    for words, other in copies:
        yield Row(f"queries: {name}", value / 1e3, "ms", words, value / other)
