"""The spatial index against a look at every point."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.errors import KnowledgeError
from rocs_bt.base.geometry import Pose2
from rocs_bt.event import NullSink
from rocs_bt.knowledge import KnowledgeGraph, Readable
from rocs_bt.knowledge.spatial_index import SpatialIndex


def drawn(rng: random.Random, shape: str) -> tuple[float, float]:
    match shape:
        case "even":
            return rng.uniform(-50.0, 50.0), rng.uniform(-50.0, 50.0)
        case "heap":
            return rng.gauss(3.0, 0.01), rng.gauss(-2.0, 0.01)
        case "heaps":
            return 1000.0 * rng.randrange(4) + rng.random(), 500.0 * rng.randrange(3) + rng.random()
        case "lattice":
            return float(rng.randrange(12)), float(rng.randrange(12))
        case "far":
            return rng.choice([-1e12, 1e300, 4.0]), rng.choice([0.0, -1e308])
    return 0.0, 0.0


@settings(max_examples=150, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    shape=st.sampled_from(["even", "heap", "heaps", "lattice", "far", "same"]),
    count=st.sampled_from([0, 1, 7, 60, 300]),
    within=st.sampled_from([0.0, 0.02, 2.0, 30.0, math.inf]),
)
def test_points_come_nearest_first_and_all_of_them(seed: int, shape: str, count: int, within: float) -> None:
    rng, space, points = random.Random(seed), SpatialIndex(), dict[str, tuple[float, float]]()
    for _ in range(count):
        name = f"p{rng.randrange(max(1, count // 2))}"
        if rng.random() < 0.15:
            points.pop(name, None)
            space.drop(name)
        else:
            points[name] = drawn(rng, shape if rng.random() < 0.97 else "even")
            space.put(name, *points[name])
    assert len(space) == len(points)
    for x, y in (drawn(rng, shape), drawn(rng, "even"), (1e5, -3e4)):
        found = [each for batch in space.rings(x, y, within) for each in batch]
        away = sorted((math.hypot(px - x, py - y), name) for name, (px, py) in points.items())
        assert found == [each for each in away if each[0] <= within]


def test_a_search_looks_at_few_of_many_points() -> None:
    rng, space = random.Random(3), SpatialIndex()
    for i in range(10_000):
        space.put(f"p{i}", rng.uniform(0.0, 100.0), rng.uniform(0.0, 100.0))
    most = max(len(next(space.rings(rng.uniform(0.0, 100.0), rng.uniform(0.0, 100.0)))) for _ in range(100))
    assert most < 40


def test_a_search_under_way_survives_what_is_written_meanwhile() -> None:
    space = SpatialIndex()
    for i in range(40):
        space.put(f"p{i}", float(i), 0.0)
    rings = space.rings(0.0, 0.0)
    found = next(rings)
    for i in range(40, 400):
        space.put(f"p{i}", float(i), 0.0)
    for batch in rings:
        found += batch
    assert [name for _, name in found][:40] == [f"p{i}" for i in range(40)]


@pytest.fixture
def graph() -> KnowledgeGraph:
    return KnowledgeGraph(SimulatedClock(0.05), NullSink(), "R2")


def test_the_graph_tells_the_nearest_of_a_kind_and_of_those_that_extend_it(graph: KnowledgeGraph) -> None:
    graph.add("box", "object", pose=Pose2(3.0, 0.0))
    graph.add("felt", "object")
    graph.add("anna", "person", pose=Pose2(0.0, 2.0))
    graph.add("home", "place", pose=Pose2(1.0, 0.0))
    assert graph.nearest(0.0, 0.0) == [(1.0, "home")]
    assert graph.nearest(0.0, 0.0, "object", limit=9) == [(2.0, "anna"), (3.0, "box")]
    assert graph.nearest(0.0, 0.0, "object", within=2.5, limit=9) == [(2.0, "anna")]
    assert graph.nearest(0.0, 0.0, "strategy") == []
    graph.set("box", pose=Pose2(0.5, 0.0))
    graph.set("anna", pose=None)
    graph.remove("home")
    assert graph.nearest(0.0, 0.0, limit=9) == [(0.5, "box")] == Readable.nearest(graph, 0.0, 0.0, limit=9)
    with pytest.raises(KnowledgeError, match=r"no kind named 'objct'\. Did you mean 'object'"):
        graph.nearest(0.0, 0.0, "objct")
