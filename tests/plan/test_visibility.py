"""The route planner `visibility`: its ways cross nothing, and no way is shorter."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocs_bt.base.clock import SimulatedClock
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.compare import length_of
from rocs_bt.event import NullSink
from rocs_bt.knowledge import Knowledge
from rocs_bt.plan import NoRoute

PLANNER = Catalog().load_route("visibility")
START, GOAL = Pose2(-3.0, 0.0), Pose2(3.0, 0.0)


def knowing(*things, radius=0.2):
    knowledge = Knowledge("R1", SimulatedClock(0.05), NullSink())
    knowledge.graph.set("R1", radius=radius)
    for i, (pose, size) in enumerate(things):
        knowledge.world.place(f"thing{i}", pose, kind="object", **size)
    return knowledge


def way(*things, start=START, goal=GOAL, clearance=0.1, radius=0.2):
    return PLANNER(knowing(*things, radius=radius)).route(start, goal, clearance)


def sampled(a, b, step=0.01):
    count = max(2, math.ceil(math.dist(a, b) / step))
    return np.linspace(a, b, count)


def gap(points, pose, size):
    """(n,) How far points are from a thing's outline [m], negative inside."""
    x, y = points[:, 0] - pose.x, points[:, 1] - pose.y
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    along, aside = np.abs(c * x + s * y), np.abs(c * y - s * x)
    if "radius" in size:
        return np.hypot(x, y) - size["radius"]
    return np.maximum(along - 0.5 * size["length"], aside - 0.5 * size["width"])


def test_around_a_round_thing_it_is_little_longer_than_the_taut_string():
    r = 0.5 + 0.2 + 0.1
    path = way((Pose2(0.0, 0.0), {"radius": 0.5}))
    tangent = math.sqrt(9.0 - r * r)
    taut = 2.0 * tangent + 2.0 * r * math.asin(r / 3.0)
    assert taut <= length_of(path) <= 1.01 * taut


@pytest.mark.parametrize(
    ("things", "why"),
    [
        ([(Pose2(3.1, 0.0), {"radius": 0.5})], "the goal is too near to 'thing0'"),
        (
            [
                (Pose2(2.0, 0.0), {"length": 0.2, "width": 3.0}),
                (Pose2(4.0, 0.0), {"length": 0.2, "width": 3.0}),
                (Pose2(3.0, 1.5), {"length": 3.0, "width": 0.2}),
                (Pose2(3.0, -1.5), {"length": 3.0, "width": 0.2}),
            ],
            "there is no path between 'thing0', 'thing1', 'thing2', 'thing3' with a clearance of 0.1 m",
        ),
    ],
)
def test_where_there_is_no_way_it_says_what_is_in_it(things, why):
    with pytest.raises(NoRoute) as caught:
        way(*things)
    assert why in str(caught.value)


def test_what_has_no_place_or_no_size_is_in_nobodys_way():
    knowledge = knowing()
    knowledge.graph.add("felt", "object", distance=0.5)
    knowledge.world.place("point", Pose2(0.0, 0.0), kind="object")
    assert PLANNER(knowledge).route(START, GOAL, 0.1) == [(-3.0, 0.0), (3.0, 0.0)]


boxes = st.builds(
    lambda x, y, yaw, length, width: (Pose2(x, y, yaw), {"length": length, "width": width}),
    st.floats(-2.0, 2.0),
    st.floats(-1.5, 1.5),
    st.floats(0.0, 3.0),
    st.floats(0.2, 1.5),
    st.floats(0.2, 1.5),
)


def grown_corners(pose, size, margin):
    half = 0.5 * size["length"] + margin, 0.5 * size["width"] + margin
    return [pose.transform(sx * half[0], sy * half[1]) for sx in (-1, 1) for sy in (-1, 1)]


@settings(max_examples=60, deadline=None, derandomize=True)
@given(st.lists(boxes, min_size=1, max_size=3))
def test_it_crosses_nothing_and_no_way_between_the_corners_is_shorter(things):
    margin = 0.3
    outer = [(pose, {k: v + 2.0 * margin for k, v in size.items()}) for pose, size in things]
    ends = np.array([START[:2], GOAL[:2]])
    if any(gap(ends, *thing).min() < 0.01 for thing in outer):
        return
    points = [START[:2], GOAL[:2], *(c for thing in things for c in grown_corners(*thing, margin))]
    far = np.full((len(points), len(points)), np.inf)
    for i, a in enumerate(points):
        for j, b in enumerate(points):
            if min(gap(sampled(a, b), *thing).min() for thing in outer) > -1e-3:
                far[i, j] = math.dist(a, b)
    for k in range(len(points)):  # Floyd and Warshall
        far = np.minimum(far, far[:, k, None] + far[None, k, :])
    try:
        path = way(*things)
    except NoRoute:
        assert not math.isfinite(far[0, 1])
        return
    assert min(gap(sampled(a, b), *thing).min() for a, b in pairwise(path) for thing in outer) > -1e-3
    assert length_of(path) <= far[0, 1] + 0.02
