"""EXP1 to EXP3 once more, by minds that get no simulator's truth: they localise."""

from __future__ import annotations

import json
import math
from functools import cache
from pathlib import Path

import pytest

from benchmarks.paper.campaign import Job, play_all
from rocs_bt import Summary, run
from rocs_bt.catalog import Catalog
from rocs_bt.declare import replaced
from rocs_bt.event import BodyMoved, ListSink, SensorRead, SignalsWritten
from rocs_bt.record import Recording
from rocs_bt.running import replay

from ..pages import data_of

CATALOG = Catalog()
LOCALISES = {"exp1_localised": ["R2"], "exp2_localised": ["R3"], "exp3_localised": ["R2", "R3"]}


@cache
def episode(scenario: str, seed: int, duration: float | None = None) -> tuple[Summary, ListSink]:
    sink = ListSink()
    return run(scenario, CATALOG, seed=seed, duration=duration, sinks=[sink]).summary, sink


@pytest.mark.parametrize(("scenario", "agents"), LOCALISES.items())
def test_only_the_robots_and_the_words_differ_from_the_experiment(scenario: str, agents: list[str]) -> None:

    spec = CATALOG.load_scenario(scenario)
    base = CATALOG.load_scenario(scenario.removesuffix("_localised"))
    assert [a.robot for a in spec.agents] == [a.robot + "_localised" for a in base.agents]
    assert [a.name for a in spec.agents] == agents
    for own, other in zip(spec.agents, base.agents, strict=True):
        assert replaced(own, robot="") == replaced(other, robot="")
    assert [(m.name, m.robot, m.parameters) for m in spec.actors] == [
        (m.name, m.robot, m.parameters) for m in base.actors
    ]
    assert (spec.world, spec.duration) == (base.world, base.duration)
    for name in {a.robot for a in spec.agents}:
        robot, truth = CATALOG.load_robot(name), CATALOG.load_robot(name.removesuffix("_localised"))
        assert (robot.model, robot.motion, robot.actuators[0].parameters) == (
            truth.model,
            truth.motion,
            truth.actuators[0].parameters,
        )


@pytest.mark.parametrize("seed", [1, 2])
def test_r2_reaches_the_origin_by_what_it_measures_itself(seed: int) -> None:
    summary, _ = episode("exp1_localised", seed)
    found = summary.agents["R2"]
    assert (found.outcome, found.reason, found.collisions) == ("success", "", 0)
    error = found.localisation
    assert 0.005 < error.position_rms < 0.1
    assert error.position_max < 0.25
    assert 0.002 < error.heading_rms < math.radians(5.0)


def test_its_estimates_are_as_sure_as_they_should_be() -> None:
    # The mean of 3 degrees of freedom over three is 1; estimates of one run depend on each other: the bounds are wide.
    means = [episode("exp1_localised", seed)[0].agents["R2"].localisation.nees for seed in range(1, 9)]
    assert 0.5 < sum(means) / len(means) < 2.0


def test_the_followers_and_the_leaders_estimates_serve_them() -> None:
    summary, _ = episode("exp3_localised", 1, duration=25.0)
    for agent in summary.agents.values():
        assert agent.outcome != "error"
        assert agent.localisation.position_rms < 0.1
    assert summary.agents["R2"].goals_reached >= 1
    assert run("exp3", CATALOG, seed=1, duration=1.0).summary.agents["R2"].localisation is None


@pytest.mark.parametrize(("scenario", "agents"), LOCALISES.items())
def test_nothing_that_the_mind_gets_is_the_truth(scenario: str, agents: list[str]) -> None:
    _, sink = episode(scenario, 1, duration=6.0)
    for agent in agents:
        truth = {e.t: e for e in sink.events if isinstance(e, BodyMoved) and e.agent == agent}
        reads = [e for e in sink.events if isinstance(e, SensorRead) and e.agent == agent]
        fixes = [e for e in reads if e.sensor in ("position", "orientation")]
        assert len(fixes) == 2 * 12, "each twice a second"
        for event in fixes:
            true = truth[event.t]
            wanted = [true.x, true.y] if event.sensor == "position" else [true.yaw]
            assert all(abs(a - b) > 1e-6 for a, b in zip(event.values, wanted, strict=False))
        poses = [e for e in sink.events if isinstance(e, SignalsWritten) and e.agent == agent and "pose" in e.signals]
        assert {e.monitor for e in poses} == {"localise"}
        assert len(poses) == len(truth) - 1, "at the last look nobody thinks any more"
        assert not [e for e in poses if e.values["pose"][:2] == [truth[e.t].x, truth[e.t].y]]


def test_a_replay_decides_the_same(tmp_path: Path) -> None:
    run("exp2_localised", CATALOG, seed=1, out=tmp_path, report=False, duration=5.0)
    assert replay(Recording.open(tmp_path / "run.mcap"), CATALOG) is None


def test_the_report_prints_the_error(tmp_path: Path) -> None:
    run("exp1_localised", CATALOG, seed=1, out=tmp_path, duration=2.0)
    numbers = dict(data_of(tmp_path / "report.html")["results"]["R2"]["numbers"])
    assert numbers["position error of the estimate, rms"].endswith(" cm")
    assert json.loads((tmp_path / "summary.json").read_text())["agents"]["R2"]["localisation"]["nees"] > 0.0


SEEDS = range(1, 101)


@pytest.mark.soak
@pytest.mark.parametrize(("scenario", "agents"), LOCALISES.items())
def test_a_hundred_seeds_with_and_without_the_truth(scenario: str, agents: list[str]) -> None:
    """Success within three points of what it is with the truth; the figures are in the test's output (`make soak`)."""
    shares: dict[str, dict[str, int]] = {}
    for name in (scenario, scenario.removesuffix("_localised")):
        runs = [found.agents for found in play_all([Job(name, seed) for seed in SEEDS])]
        shares[name] = {agent: sum(r[agent].outcome == "success" for r in runs) for agent in agents}
        for agent in agents if name == scenario else ():
            told = [r[agent].localisation for r in runs]
            print(scenario, agent, {key: sum(t[key] for t in told) / len(told) for key in told[0]})
    print(shares)
    own, true = shares[scenario], shares[scenario.removesuffix("_localised")]
    assert all(own[agent] >= true[agent] - 3 for agent in agents)
