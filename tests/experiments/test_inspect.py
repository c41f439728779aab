"""A tank inspected from the air at two heights, with a boom that swings into the upper circle, and the landing."""

from __future__ import annotations

import math
from functools import cache
from itertools import pairwise

import pytest

from rocs_bt import Summary, run
from rocs_bt.base.geometry import wrap_angle
from rocs_bt.catalog import Catalog
from rocs_bt.declare import replaced
from rocs_bt.event import BodyMoved, ListSink

CATALOG = Catalog()
SCENARIO = CATALOG.load_scenario("inspect")
RADIUS = 1.9  # [m]
HEIGHTS = (0.8, 1.7)  # [m] of the two circles
PAD = (-3.2, 0.0)
CALM, HELD_OFF = 3, 1
"""Seeds without and with the boom in the way."""


@cache
def episode(seed: int, *rules: str) -> tuple[Summary, list[BodyMoved]]:
    """Summary, and poses of the robot in each control period."""
    sink = ListSink()
    summary = run(
        replaced(SCENARIO, agents=(replaced(SCENARIO.agents[0], rules=rules),)), CATALOG, seed=seed, sinks=[sink]
    )
    return summary.summary, [e for e in sink.events if isinstance(e, BodyMoved) and e.body == "Q"]


def circling(moved: list[BodyMoved], height: float) -> list[BodyMoved]:
    """Poses on the circle at a height."""
    return [e for e in moved if abs(e.height - height) < 0.06 and math.hypot(e.x, e.y) < RADIUS + 0.06]


@pytest.mark.parametrize("seed", [CALM, HELD_OFF, *(pytest.param(s, marks=pytest.mark.soak) for s in range(5, 15))])
def test_both_circles_are_flown_without_a_contact(seed: int) -> None:
    summary, moved = episode(seed, "airborne")
    found = summary.agents["Q"]
    assert (found.outcome, found.contacts, found.fell) == ("success", {}, False)
    for height in HEIGHTS:
        angles = [math.atan2(e.y, e.x) for e in circling(moved, height)]
        turned = math.fsum(wrap_angle(b - a) for a, b in pairwise(angles))
        assert turned == pytest.approx(2.0 * math.pi, abs=0.2)


@pytest.mark.parametrize("seed", [CALM, HELD_OFF])
def test_the_robot_looks_at_the_tank_on_both_circles(seed: int) -> None:
    _, moved = episode(seed, "airborne")
    for height in HEIGHTS:
        off = [abs(wrap_angle(math.atan2(-e.y, -e.x) - e.yaw)) for e in circling(moved, height)]
        assert max(off) < math.radians(10.0)


def test_the_robot_lands_on_its_pad() -> None:
    _, moved = episode(CALM, "airborne")
    end = moved[-1]
    assert math.dist((end.x, end.y), PAD) < 0.2
    assert end.height == pytest.approx(0.1, abs=0.01)
    assert max(e.height for e in moved) > HEIGHTS[1] - 0.1


def test_a_reflex_holds_the_robot_off_the_boom_that_hits_it_otherwise() -> None:
    held, _ = episode(HELD_OFF, "airborne")
    assert held.agents["Q"].reflex_activations > 0
    assert held.agents["Q"].replans > 0
    hit, _ = episode(HELD_OFF)
    assert hit.agents["Q"].contacts
    assert hit.agents["Q"].outcome != "success" or hit.agents["Q"].collisions
