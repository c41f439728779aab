"""EXP2, whole: another robot, the same rules and engine; it goes to a place, gives way, and comes back."""

from __future__ import annotations

import math
from functools import cache

import pytest

from rocs_bt import run
from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved, ContactBegan, GoalEntered, ListSink
from rocs_bt.running import replay

CATALOG = Catalog()
EXP2 = CATALOG.load_scenario("exp2")
SEEDS = (1, 26)  # R1 comes near in the second; `make soak` plays a hundred


@cache
def episode(seed: int, duration: float = 60.0) -> tuple[dict, ListSink]:
    """The summary of R3 in a run, and all events."""
    sink = ListSink()
    return run(EXP2, CATALOG, seed=seed, duration=duration, sinks=[sink]).summary.agents["R3"], sink


@pytest.mark.parametrize("seed", SEEDS)
def test_it_reaches_its_place_and_runs_into_nothing(seed: int) -> None:
    summary, sink = episode(seed)
    entered = [e.t for e in sink.events if isinstance(e, GoalEntered) and e.agent == "R3"]
    assert 4.0 < entered[0] < 8.0
    assert not [e for e in sink.events if isinstance(e, ContactBegan) and e.agent == "R3" and e.kind == "collision"]
    assert summary.outcome in ("success", "timeout")


def test_it_is_there_at_the_end_unless_the_walker_is() -> None:
    there = []
    for seed in SEEDS:
        summary, sink = episode(seed)
        last = {e.body: e for e in sink.events if isinstance(e, BodyMoved)}
        assert last["R3"].t == pytest.approx(60.0)
        there.append(math.hypot(last["R3"].x - 1.2, last["R3"].y - 1.2) <= 0.1)
        assert (summary.outcome == "success") is there[-1]
        near = math.hypot(last["R3"].x - last["R1"].x, last["R3"].y - last["R1"].y) < 1.5
        assert there[-1] or near
    assert all(there)


def test_what_pushes_it_off_is_a_reflex_and_it_comes_back() -> None:
    came_back = 0
    for seed in SEEDS:
        summary, sink = episode(seed)
        assert summary.collisions == 0
        entered = [e.t for e in sink.events if isinstance(e, GoalEntered) and e.agent == "R3"]
        if len(entered) >= 2:
            assert summary.reflex_activations > 0
            assert summary.actions["GoTo"]["SUCCEEDED"] >= 2
            came_back += 1
    assert came_back > 0


def test_it_is_the_robot_and_not_the_mind_that_differs_from_exp1() -> None:
    (one,), (other,) = CATALOG.load_scenario("exp1").agents, EXP2.agents
    assert one.rules == other.rules
    assert one.robot != other.robot
    assert [m.script for m in EXP2.actors] == [m.script for m in CATALOG.load_scenario("exp1").actors]


def test_a_run_that_is_cut_short_before_it_arrived_is_no_success() -> None:
    summary, _ = episode(1, duration=3.0)
    assert summary.outcome == "timeout"
    assert "the mission is still RUNNING" in summary.reason
    assert summary.reason.endswith("; GoTo(goal) has run for 3.0 s")


def test_a_replay_decides_the_same(tmp_path) -> None:
    from rocs_bt.record import Recording

    run("exp2", CATALOG, seed=1, out=tmp_path, report=False, duration=8.0)
    assert replay(Recording.open(tmp_path / "run.mcap"), CATALOG) is None
