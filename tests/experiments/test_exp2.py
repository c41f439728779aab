"""EXP2, whole: another robot, the same rules and engine; it goes to a place, gives way, and comes back."""

from __future__ import annotations

import dataclasses
import math
from functools import cache

import pytest

from rocs_bt.catalog import Catalog
from rocs_bt.event import BodyMoved, GoalEntered, ListSink, Touched
from rocs_bt.simulation import replay, run

CATALOG = Catalog()
EXP2 = CATALOG.load_scenario("exp2")
SEEDS = (1, 5, 6, 7)


@cache
def episode(seed: int, facing: str = "", duration: float = 60.0) -> tuple[dict, ListSink]:
    """The summary of R3 in a run, and all events; it may face another way than the scenario says."""
    (agent,) = EXP2.agents
    parameters = {**agent.parameters, **({"facing": facing} if facing else {})}
    sink = ListSink()
    spec = dataclasses.replace(EXP2, agents=(dataclasses.replace(agent, parameters=parameters),))
    return run(spec, CATALOG, seed=seed, duration=duration, sinks=[sink]).summary["agents"]["R3"], sink


@pytest.mark.parametrize("seed", SEEDS)
def test_it_reaches_its_place_and_is_there_at_the_end(seed: int) -> None:
    summary, sink = episode(seed)
    assert (summary["outcome"], summary["reason"]) == ("success", "")
    assert 5.0 < summary["time_to_goal"] < 10.0
    assert not [e for e in sink.events if isinstance(e, Touched) and e.agent == "R3" and e.other != "R1"]
    last = [e for e in sink.events if isinstance(e, BodyMoved) and e.body == "R3"][-1]
    assert last.t == pytest.approx(60.0)
    assert math.hypot(last.x - 1.2, last.y - 1.2) <= 0.1


def test_what_pushes_it_off_is_a_reflex_and_it_comes_back() -> None:
    summary, sink = episode(97, "-135 deg")
    assert summary["reflex_activations"] > 0
    entered = [e.t for e in sink.events if isinstance(e, GoalEntered) and e.agent == "R3"]
    assert len(entered) >= 2
    assert summary["outcome"] == "success"
    assert summary["actions"]["GoTo"]["SUCCEEDED"] >= 2


def test_it_is_the_robot_and_not_the_mind_that_differs_from_exp1() -> None:
    (one,), (other,) = CATALOG.load_scenario("exp1").agents, EXP2.agents
    assert one.rules == other.rules
    assert one.robot != other.robot
    assert [m.script for m in EXP2.movers] == [m.script for m in CATALOG.load_scenario("exp1").movers]


def test_a_run_that_is_cut_short_before_it_arrived_is_no_success() -> None:
    summary, _ = episode(1, duration=3.0)
    assert summary["outcome"] == "timeout"
    assert "the mission is still RUNNING" in summary["reason"]


def test_a_replay_decides_the_same(tmp_path) -> None:
    from rocs_bt.record import Recording

    run("exp2", CATALOG, seed=1, out=tmp_path, report=False, duration=8.0)
    assert replay(Recording.open(tmp_path / "run.mcap"), CATALOG) is None
