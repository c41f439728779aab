"""A quadruped patrols rough ground, a slope and steps, and recovers from a push; the tilt rule stops it."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path

import pytest

import rocs_bt
from rocs_bt import Summary
from rocs_bt.base.geometry import Pose2
from rocs_bt.catalog import Catalog, PushSpec
from rocs_bt.declare import replaced
from rocs_bt.event import BodyMoved, Event, ListSink, RobotPushed, RuleChanged
from rocs_bt.record import Recording
from rocs_bt.record.figures.plot import FIGURES
from rocs_bt.record.fold.history import History

CATALOG = Catalog()
SCENARIO = CATALOG.load_scenario("patrol_rough")
ROUND = ["north_west", "north_east", "south_east", "home"]


@cache
def episode(seed: int, *pushes: PushSpec, duration: float = SCENARIO.duration) -> tuple[Summary, list[Event]]:
    """Summary and events of one run with these pushes."""
    sink = ListSink()
    scenario = replaced(SCENARIO, pushes=pushes, duration=duration)
    return rocs_bt.run(scenario, CATALOG, seed=seed, sinks=[sink]).summary, sink.events


def moves(events: list[Event], begin: float = 0.0, end: float = math.inf) -> list[BodyMoved]:
    return [e for e in events if isinstance(e, BodyMoved) and e.body == "R2" and begin <= e.t < end]


def visits(events: list[Event]) -> list[str]:
    """Places in the order in which the robot came to them, after the start."""
    found = ["home"]
    for e in moves(events):
        near = [p.name for p in SCENARIO.places if p.pose.distance(Pose2(e.x, e.y, e.yaw)) < p.tolerance]
        found += [name for name in near if name != found[-1]]
    return found[1:]


@pytest.mark.parametrize("seed", [1, *(pytest.param(seed, marks=pytest.mark.soak) for seed in range(2, 13))])
def test_the_round_is_walked_in_order_on_rough_ground_in_spite_of_a_push(seed: int) -> None:
    summary, events = episode(seed, *SCENARIO.pushes)
    found = summary.agents["R2"]
    assert (found.outcome, found.collisions, found.fell) == ("success", 0, False)
    assert visits(events) == ROUND
    (push,) = (e for e in events if isinstance(e, RobotPushed))
    assert math.hypot(*push.force) == pytest.approx(60.0)
    assert 4.0 <= push.t <= 40.1
    heights = [e.height or 0.0 for e in moves(events)]
    assert max(heights) - min(heights) > 0.17, "over the slope"


def test_a_push_is_felt_and_recorded() -> None:
    push = PushSpec(robot="R2", force=(0.0, 60.0, 0.0), at=4.0, duration=0.1)
    tilts = []
    for pushes in ((push,), ()):
        _, events = episode(1, *pushes, duration=6.0)
        assert len([e for e in events if isinstance(e, RobotPushed)]) == len(pushes)
        tilts.append([e.tilt for e in moves(events, 4.0, 4.6)])
    assert max(tilts[0]) > max(tilts[1]) + math.radians(2.0)


@pytest.mark.soak  # falls and getting up: tests/simulation/test_fall.py
@pytest.mark.parametrize("at", [10.0, 18.0])
def test_a_fall_away_from_obstacles_costs_some_seconds(at: float) -> None:
    push = PushSpec(robot="R2", force=(0.0, 270.0, 0.0), at=at, duration=0.1)
    summary, events = episode(1, push)
    rules = [e for e in events if isinstance(e, RuleChanged) and e.rule.startswith("upright/")]
    fired = [e for e in rules if e.phase == "fired"]
    assert [e.rule for e in fired[:2]] == ["upright/Upright", "upright/GetUp"]
    before = moves(events, at, fired[0].t + 0.01)
    assert 20.0 < math.degrees(max(e.tilt for e in before)) < 40.0
    assert max(e.tilt for e in moves(events, at, at + 3.0)) > math.radians(80.0)
    found = summary.agents["R2"]
    assert (found.outcome, found.collisions, found.fell) == ("success", 0, False)
    assert visits(events) == ROUND


def test_height_and_tilt_are_drawn(tmp_path: Path) -> None:
    scenario = replaced(SCENARIO, duration=1.0)
    run = History(Recording.open(rocs_bt.run(scenario, CATALOG, seed=1, out=tmp_path, report=False).recording))
    (height,) = [figure for figure in FIGURES if figure.name == "height"]
    assert height.applies([run])
    assert b"-tilt" in height.render([run], "svg")
