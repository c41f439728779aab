"""Every planner we ship: it plays, repeats, knows only what it may know; and those that drive come to an easy goal."""

from __future__ import annotations

from dataclasses import replace

import pytest

from rocs_bt import Pose2
from rocs_bt.catalog import Catalog
from rocs_bt.compare import Block, FamilyScene, Floor, Post, Scene, goal_scenario, load_family
from rocs_bt.compare.episode import Episode, GeneratedScene
from rocs_bt.compare.runner import EpisodeRunner
from rocs_bt.declare import replaced

OFFICE = FamilyScene("office", 3)
NAMES = [entry.name for entry in Catalog().list("planner")]


def played(name, privileged=True):
    """Two seconds in an office, on a bench of its own."""
    runner = EpisodeRunner()
    prepared = runner.prepare(OFFICE)
    given = prepared.privileged if privileged else {}
    short = replace(
        prepared,
        scenario=replaced(prepared.scenario, duration=2.0),
        privileged=given,
    )
    runner._prepared[OFFICE] = short
    return runner.play(Episode("key", runner.catalog.load_planner(name), OFFICE, 1))


@pytest.mark.parametrize("name", NAMES)
def test_it_plays_repeats_and_is_told_only_what_it_may_be_told(name):
    """A planner that looked at the true ground would drive otherwise, or break down, where nobody tells of it."""
    record = played(name)
    assert record.outcome != "error", record.reason
    assert record.reproducible
    if name == "oracle":
        blind = played(name, privileged=False)
        assert (blind.outcome, "needs a scene with a ground-truth map" in blind.reason) == ("failed", True)
        assert played(name).trajectory_hash == record.trajectory_hash
    else:
        assert played(name, privileged=False).trajectory_hash == record.trajectory_hash


def test_only_the_oracles_are_some():
    assert [name for name in NAMES if Catalog().load_planner(name).oracle] == ["among_oracle", "oracle"]


DRIVE = sorted({"hybrid", *(n for n in NAMES if n.split("_among")[0] in ("pure_pursuit", "dynamic_window", "mppi"))})


@pytest.fixture
def easy():
    """A room of 6 m with two posts and a wall end beside the way: a Jackal is to come from one side to the other."""
    floor = Floor((-1.0, -3.0), (6.0, 3.0))
    floor.obstacles += [
        Post("left", 2.0, 1.0, 0.15),
        Post("right", 3.0, -0.9, 0.15),
        Block("wall", 2.5, 2.2, 0.1, 1.0),
    ]
    driver = load_family(Catalog(), "office")
    scenario = goal_scenario(driver, "easy", "Easy.", Pose2(0.0, 0.0, 0.3), (4.0, 0.3), tolerance=0.4, duration=20.0)
    return GeneratedScene.of(Scene(scenario, floor))


@pytest.mark.parametrize("name", DRIVE)
def test_those_that_drive_with_a_map_of_their_own_come_to_an_easy_goal(name, easy):
    runner = EpisodeRunner()
    record = runner.play(Episode("key", runner.catalog.load_planner(name), easy, 1))
    assert (record.outcome, record.reason) == ("success", "")
    assert record.metrics["path_length"] < 6.0
